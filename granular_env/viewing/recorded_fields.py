"""Recorded arrays of a log, instants by places: what x-t diagrams, profiles and histories draw."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.drawables import Curve, Drawable, main_points
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable

from .input_curves import acting_stretches, component_names, values_at
from .scene_data import MAXIMUM_POINTS, MAXIMUM_SHOWN_PARTICLES, Motion, cuts_of, evenly_picked, sample_frames


@dataclass(frozen=True)
class Field:
    """A quantity with a value for each of several particles, contacts, ..., in some frames of a run.

    Attributes:
        variable: name, unit and meaning.
        times: shape (frames,) [s].
        values: shape (frames, n), in the variable's unit.
        place: what there is one value for, by the variable's `axes`: "grain", "contact", ...; "element" where they do not say.
        axis: the label of the axis along them.
        every: each `every`-th is shown; 1 shows all.
        total: how many there are.
        cuts: indices of the first frames of later segments.
        coordinate: where those shown lie, evenly spaced, shape (n,) [m]; None where their numbers say where they are.
    """

    variable: Variable
    times: FloatArray
    values: FloatArray
    place: str
    axis: str
    every: int = 1
    total: int = 0
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    coordinate: FloatArray | None = None

    @property
    def across(self) -> FloatArray | npt.NDArray[np.int64]:
        """The numbers along the axis of places: their coordinates, or where there are none their numbers."""
        return np.arange(self.values.shape[1]) * self.every if self.coordinate is None else self.coordinate

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of that axis: where the first place begins, and where the last one ends."""
        across = self.across
        half = 0.5 * (float(across[1] - across[0]) if len(across) > 1 else float(self.every))
        return float(across[0]) - half, float(across[-1]) + half


def as_field(shown: Motion | Field) -> Field:
    """Return a field as it is, and of a motion the quantity that colours it; `ParameterError` where that was not recorded."""
    if isinstance(shown, Field):
        return shown
    if shown.colour is None:
        name = shown.colour_variable.name
        raise ParameterError(
            f"{name!r} was not recorded, so it cannot be drawn", hint="add it to the recorded variables", at="variables"
        )
    place, axis = _axis(shown.colour_variable, 0 if _is_row(shown.reference) else None)
    return Field(shown.colour_variable, shown.times, shown.colour, place, axis, shown.every, shown.total, shown.cuts)


def field_names(log: Any) -> list[str]:
    """Return the names of the recorded outputs that have a value for each of several places."""
    return [
        name
        for name, variable in log.variables.items()
        if variable.causality == "output" and len(variable.shape) == 1 and variable.shape[0] > 1 and len(log.times(name))
    ]


def load_field(log: Any, name: str, frames: int, progress: Callable[[float], None] | None = None) -> Field:
    """Read a recorded array of a log, at most so many frames and 20 000 places of it.

    Raises:
        ParameterError: there is no such recorded array.
    """
    if name not in field_names(log):
        raise ParameterError(
            f"{name!r} is no recorded array of this log", hint=f"it holds {_list(field_names(log))}", at="variables"
        )
    variable = log.variables[name]
    total = variable.shape[0]
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    count = -(-total // every)
    picked = evenly_picked(len(log.times(name)), max(2, min(frames, MAXIMUM_POINTS // count)))
    times, values = sample_frames(log, name, picked, progress)
    points = main_points(log.drawables)
    surplus = total - len(points.radius) if points is not None and _is_row(points.reference) else None
    place, axis = _axis(variable, surplus, points.name.removesuffix("s") if points is not None else "")
    coordinate = _coordinate(log.drawables, name)
    if coordinate is not None:
        axis, coordinate = "x [m]", coordinate[::every]
    return Field(variable, times, values[:, ::every], place, axis, every, total, cuts_of(log, name, picked), coordinate)


def vector_names(log: Any) -> list[str]:
    """Return the names of the recorded outputs that have more than one axis, such as a vector for each of several places."""
    return [
        name for name, one in log.variables.items() if one.causality == "output" and len(one.shape) > 1 and len(log.times(name))
    ]


def load_vector_fields(log: Any, name: str, frames: int) -> list[Field]:
    """Read a recorded output of `vector_names`: one field for each component, or where those are many one of all elements."""
    variable = log.variables[name]
    names = component_names(variable)
    total = prod(variable.shape) // len(names)
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    picked = evenly_picked(len(log.times(name)), max(2, min(frames, MAXIMUM_POINTS // -(-total // every))))
    times, values = sample_frames(log, name, picked)
    shown = values.reshape(len(times), total, len(names))[:, ::every]
    return _split(log, variable, times, shown, every, cuts_of(log, name, picked))


def load_input_fields(log: Any, name: str, frames: int) -> list[Field]:
    """Return an array input of a log at evenly spaced instants: one field, or of vectors one for each component.

    Of many elements only some are read, as in `load_field`, and none at more instants than are drawn.
    """
    variable = log.input_variables[name]
    names = component_names(variable)
    total = prod(variable.shape) // len(names)
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    held = acting_stretches(log, name)
    first, last = held[0].begin + held[0].shift, held[-1].end + held[-1].shift
    count = max(2, min(frames, MAXIMUM_POINTS // (-(-total // every))))
    ticks = np.unique(np.linspace(first, last, count).astype(np.int64))
    values = np.stack([np.reshape(value, (total, len(names)))[::every] for value in values_at(held, ticks.tolist())])
    return _split(log, variable, ticks * log.step_size, values, every, np.zeros(0, np.int64))


def _split(
    log: Any,
    variable: Variable,
    times: FloatArray,
    values: FloatArray,
    every: int,
    cuts: npt.NDArray[np.int64],
) -> list[Field]:
    """Return a field for each component of vectors; `values` has the shape (frames, shown, components)."""
    total, names = prod(variable.shape) // values.shape[2], component_names(variable)
    place, axis = _axis(variable, None)
    coordinate = _coordinate_of_axis(log, variable)
    if coordinate is not None:
        axis, coordinate = "x [m]", coordinate[::every]
    return [
        Field(replace(variable, name=name), times, values[:, :, column], place, axis, every, total, cuts, coordinate)
        for column, name in enumerate(names)
    ]


def require_names(names: Sequence[str] | None, known: Sequence[str], recorded: Container[str] = ()) -> list[str]:
    """Return the names that were asked for, all known ones where none were; `ParameterError` where one is unknown.

    `recorded` are those of the log, of which not all can be drawn.
    """
    if names is None:
        return list(known)
    if isinstance(names, str) or not all(isinstance(name, str) for name in names):
        raise ParameterError(f"got {names!r}", expected=f"a list of names, of {_list(known)}", at="variables")
    for name in names:
        if name not in known:
            why = "cannot be drawn as a field or a curve" if name in recorded else "was not recorded"
            what = "what can is" if name in recorded else "this log holds"
            raise ParameterError(f"{name!r} {why}", hint=f"{what} {_list(known)}", at="variables")
    return list(dict.fromkeys(names))


def _coordinate_of_axis(log: Any, variable: Variable) -> FloatArray | None:
    """Return the coordinate along which an output with the same axis is drawn as a curve, where that is evenly spaced [m]."""
    for one in log.drawables:
        drawn = log.variables.get(one.field) if isinstance(one, Curve) else None
        if drawn is not None and drawn.axes and drawn.axes == variable.axes[:1] and drawn.shape == variable.shape[:1]:
            return _coordinate(log.drawables, drawn.name)
    return None


def _coordinate(drawables: Sequence[Drawable], name: str) -> FloatArray | None:
    """Return the coordinate along which an output is drawn as a curve, where that is evenly spaced [m]."""
    for one in drawables:
        if isinstance(one, Curve) and one.field == name and len(one.coordinate) > 1:
            steps = np.diff(one.coordinate)
            if steps[0] > 0.0 and np.ptp(steps) < 1e-6 * steps[0]:
                return one.coordinate
    return None


def _is_row(reference: FloatArray) -> bool:
    """Return whether points lie in a row along x; their places have shape (n, 3)."""
    return not np.ptp(reference[:, 1:], axis=0).any()


def _axis(variable: Variable, surplus: int | None, point: str = "") -> tuple[str, str]:
    """Return what the values belong to, and the label of the axis along them.

    Args:
        variable: the quantity; its `axes` say what its values belong to.
        surplus: how many more values than points there are; None where the points are not in a row.
        point: what one point is called.
    """
    place = variable.axes[0].replace("_", " ") if variable.axes else "element"
    notes = {0: "0 is the left end", 1: f"i is left of {point} i", -1: f"i is right of {point} i"}
    return place, f"{place} ({'numbered from 0' if surplus is None else notes.get(surplus, 'numbered from 0')})"


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"
