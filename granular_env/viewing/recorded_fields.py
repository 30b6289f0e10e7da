"""Recorded outputs of a log, read for viewers and figures: as curves over time, and as fields (values at times and places)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.drawables import Curve, Drawable
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.element_arrays import element_arrays
from granular_env.recording.preview.visible_drawables import colouring_outputs, is_hidden, with_colour, with_recorded_colour
from granular_env.recording.steps import acting_intervals, sample_intervals

from . import curves
from .curves import component_names, pick_with_extremes
from .places import place_name, place_noun, variable_positions, vector_names
from .scene_data import MAXIMUM_POINTS, MAXIMUM_SHOWN_PARTICLES, Motion
from .unit_labels import scaled_label


def validity_limit(log: Any) -> tuple[float, str]:
    """Return the time at which the results cease to be valid [s], and a sentence on it; infinity and "" if they stay valid."""
    details = log.event_details
    for event in (*(log.earlier_events() or ()), *log.events()):
        if event.kind in details and details[event.kind].ends_validity:
            time = event.tick * log.step_size
            return time, f"Not valid from {1e6 * time:.4g} \u00b5s on: {event.kind.replace('_', ' ')}."
    return np.inf, ""


def located_events(log: Any) -> list[Any]:
    """Return the events located at a drawn element, such as a broken link."""
    details = log.event_details
    return [event for event in log.events() if event.kind in details and details[event.kind].counts]


def recorded_outputs(log: Any) -> dict[str, Variable]:
    """Return the outputs with elements and recorded frames, by name."""
    return {
        name: one
        for name, one in log.variables.items()
        if one.causality == "output" and prod(one.shape) and len(log.frame_rows(name))
    }


def coloured_drawables(log: Any, colour: str | None) -> tuple[Drawable, ...]:
    """Return the drawables of a log, coloured by the output `colour` or, for None, by the component's choice.

    If the output of points or cells was not recorded, the first recorded output that can colour them is used.

    Raises:
        ParameterError: the output can colour no drawable.
    """
    recorded = recorded_outputs(log)
    known = colouring_outputs([one for one in log.drawables if not is_hidden(one, log.drawables)], recorded)
    if colour is not None and colour not in known:
        raise ParameterError(
            f"{colour!r} was not recorded, or does not have one value per node, cell or point of a drawable",
            hint=f"this log can be coloured by {', '.join(known) or 'nothing'}", at="colour",
        )  # fmt: skip
    found: list[Drawable] = []
    for one in log.drawables:
        is_chosen = colour in colouring_outputs([one], recorded)
        found.append(with_colour(one, colour or "") if is_chosen else with_recorded_colour(one, recorded))
    return tuple(found)


def curve_names(variable: Variable) -> list[str]:
    """Return the names of the curves that show a variable: one for a single number, one per component of a short vector."""
    if variable.shape in ((), (1,)):
        return [variable.name]
    return [f"{variable.name}_{entry}" for entry in vector_names(variable.shape, variable.axes)]


def nearest_frame(times: FloatArray, time: float) -> int:
    """Return the index of the frame nearest to a time [s]; raise `ParameterError` for a time outside the recorded span."""
    first, last = float(times[0]), float(times[-1])
    slack = 1e-9 * max(abs(first), abs(last))
    if not first - slack <= time <= last + slack:
        raise ParameterError(f"got {time:g} s", expected=f"{first:g} to {last:g} s, the recorded span", at="times")
    return int(np.argmin(np.abs(times - time)))


def pick_evenly(available: int, count: int) -> npt.NDArray[np.int64]:
    """Return the indices of at most `count` of the `available` frames, evenly spaced, including the first and the last."""
    if available <= count:
        return np.arange(available)
    return np.unique(np.rint(np.linspace(0, available - 1, count)).astype(np.int64))


def segment_starts(log: Any, name: str, frames: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the positions in `frames` (picked frame indices) at which the log's second and later segments begin."""
    ticks, lengths = np.asarray(log.ticks(name)), [segment.end - segment.start for segment in log.segments]
    bounds = log.start_tick + np.cumsum(lengths[:-1], dtype=np.int64)
    # Two segments may have a frame at the same tick; the second frame begins the later segment.
    after = np.searchsorted(ticks, bounds, side="right")
    firsts = np.where(np.isin(bounds, ticks), after - 1, after)
    cuts = np.unique(np.searchsorted(frames, firsts))
    return cuts[(cuts > 0) & (cuts < len(frames))]


def evenly_spaced_series(log: Any, name: str, elements: Sequence[int] | None = None) -> tuple[float, FloatArray]:
    """Return the time between two frames [s] and the values of a variable in all frames, as `Log.frames_at`.

    Raises:
        ParameterError: the frames are not evenly spaced in time, or there are fewer than three.
    """
    ticks = np.asarray(log.ticks(name))
    if len(ticks) > 3 and 0 < ticks[-1] - ticks[-2] < ticks[1] - ticks[0]:
        ticks = ticks[:-1]  # the last frame is early if the run ends between two frames
    steps = np.diff(ticks)
    if len(ticks) < 3 or steps[0] == 0 or np.ptp(steps):
        raise ParameterError(
            f"the {len(ticks)} frames of {name!r} have no common interval",
            expected="three or more evenly spaced frames of one run without a reset",
            hint="record with a fixed time between frames: `every`", at="variable",
        )  # fmt: skip
    return float(steps[0]) * log.step_size, log.frames_at(name, np.arange(len(ticks)), elements)


def load_curves(log: Any, name: str) -> Iterator[curves.Curve]:
    """Yield a recorded scalar, or each component of a short vector, as a curve thinned without losing peaks."""
    variable, (times, values) = log.variables[name], log.series(name)
    for column, shown in enumerate(curve_names(variable)):
        own = values if values.ndim == 1 else values[:, column]
        picked = pick_with_extremes(own)
        ticks, cuts = np.asarray(log.ticks(name))[picked], segment_starts(log, name, picked)
        yield curves.Curve(shown, variable.unit, variable.description, times[picked], ticks, own[picked], cuts)


@dataclass(frozen=True)
class Field:
    """A quantity with one value per place (particle, contact, cell, ...) in some frames of a run.

    Attributes:
        variable: name, unit and meaning of the quantity.
        times: shape (frames,) [s].
        values: shape (frames, n), in the variable's unit.
        every: every `every`-th place is shown; 1 shows all.
        total: the number of places.
        cuts: indices of the first frames of later segments.
        coordinate: evenly spaced coordinates, shape (n,) [m]; None if the places are only numbered.
        positions: initial positions of all places, shape (total, d) [m]; None if unknown.
        run: name of the run in a figure of several runs.
    """

    variable: Variable
    times: FloatArray
    values: FloatArray
    every: int = 1
    total: int = 0
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    coordinate: FloatArray | None = None
    positions: FloatArray | None = None
    run: str = ""

    @property
    def place(self) -> str:
        """The name of a single place, such as "grain" or "contact"."""
        return place_noun(self.variable)

    @property
    def coordinates(self) -> FloatArray | npt.NDArray[np.int64]:
        """The coordinates of the places or, if unknown, their numbers."""
        return np.arange(self.values.shape[1]) * self.every if self.coordinate is None else self.coordinate

    @property
    def place_axis(self) -> tuple[float, str]:
        """The factor of the coordinates along the places, and the label of their axis with its unit."""
        if self.coordinate is not None:
            return scaled_label("x", "m", float(np.abs(self.coordinate).max()))
        return 1.0, f"{self.place} (numbered from 0{f'; 1 in {self.every} is shown' if self.every > 1 else ''})"

    def history(self, number: int) -> curves.Curve:
        """Return the values of a place over time; with `every` above 1, of the nearest place shown before it."""
        column, nowhere = number // self.every, np.zeros(0, np.int64)
        about, label = self.variable, self.place_name(column * self.every)
        return curves.Curve(
            about.name, about.unit, about.description, self.times, nowhere, self.values[:, column], self.cuts, label
        )

    def place_name(self, number: int) -> str:
        """Return the name of a place, after the name of the run if there are several."""
        name = place_name(self.place, number, self.positions)
        return f"{self.run}: {name}" if self.run else name

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends of the axis along the places: half a spacing before the first place and after the last place."""
        across = self.coordinates
        half = 0.5 * (float(across[1] - across[0]) if len(across) > 1 else float(self.every))
        return float(across[0]) - half, float(across[-1]) + half


def to_field(source: Motion | Field) -> Field:
    """Return a field unchanged; of particles, the quantity that colours them as a field, `ParameterError` if not recorded."""
    if isinstance(source, Field):
        return source
    if source.colour is None:
        name = source.colour_variable.name
        raise ParameterError(
            f"{name!r} was not recorded, so it cannot be drawn", hint="add it to the recorded variables", at="variables"
        )
    return Field(source.colour_variable, source.times, source.colour, source.every, source.total, source.cuts)


def load_fields(log: Any, name: str, frames: int) -> list[Field]:
    """Read a recorded array or array input of a log as one field, or as one field per component of vectors.

    Read at most `frames` frames and 20 000 places.
    """
    is_input = name in log.input_variables
    variable: Variable = log.input_variables[name] if is_input else log.variables[name]
    names = component_names(variable)
    total = prod(variable.shape) // len(names)
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    most = max(2, min(frames, MAXIMUM_POINTS // -(-total // every)))
    cuts = np.zeros(0, np.int64)
    if is_input:
        held = acting_intervals(log, name)
        first, last = held[0].begin + held[0].shift, held[-1].end + held[-1].shift
        ticks = np.unique(np.linspace(first, last, most).astype(np.int64))
        times = ticks * log.step_size
        rows = (np.reshape(value, (total, len(names)))[::every] for value in sample_intervals(held, ticks.tolist()))
        values = np.stack(list(rows))
    else:
        clock = log.times(name)
        picked = pick_evenly(len(clock), most)
        times, whole = clock[picked], log.frames_at(name, picked)
        values, cuts = whole.reshape(len(times), total, len(names))[:, ::every], segment_starts(log, name, picked)
    # An array with several values per element, such as layers of a shell, has more places than positions.
    is_placed = total == variable.shape[0]
    coordinate, positions = (_coordinate(log, variable), variable_positions(log, variable)) if is_placed else (None, None)
    coordinate = None if coordinate is None else coordinate[::every]
    return [
        Field(replace(variable, name=one), times, values[:, :, column], every, total, cuts, coordinate, positions)
        for column, one in enumerate(names)
    ]


def _coordinate(log: Any, variable: Variable) -> FloatArray | None:
    """Return the coordinates of a variable's places [m] if they are the evenly spaced samples of a curve along x."""
    for one in log.drawables:
        if isinstance(one, Curve) and variable.name in element_arrays(one, {**log.variables, variable.name: variable})[0]:
            steps = np.diff(one.coordinate)
            if len(steps) and np.ptp(steps) < 1e-6 * steps[0]:
                return one.coordinate
    return None
