"""The figures of a report: every recorded array and every scalar that is not zero all the time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.components.drawables import Cells, Points
from granular_env.components.errors import ParameterError

from ..curves import Curve, InputCurves, load_input
from ..figures import plane, run_figures
from ..plot_groups import plots
from ..recorded_fields import (
    Field,
    as_field,
    field_names,
    load_field,
    load_input_fields,
    load_vector_fields,
    recorded_outputs,
    require_names,
    vector_names,
)
from ..scene_builder import from_log
from ..scene_data import SceneData
from ..visible_drawables import Place, colouring_outputs, is_solid, place_of_output

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES = 2000
_DIRECTIONS = "xyz"


@dataclass(frozen=True)
class Shown:
    """A figure, the heading that it stands under, and what it shows in words."""

    heading: str
    figure: Figure
    words: str


@dataclass(frozen=True)
class Choice:
    """A wish for what a report shows: names of variables, instants [s], places; None for what suits the log."""

    variables: Sequence[str] | None = None
    times: Sequence[float] | None = None
    indices: Sequence[int] | None = None

    def check(self, log: Any) -> None:
        """Raise `ParameterError` for what this log does not hold."""
        for name, values in (("times", self.times), ("indices", self.indices)):
            if values is not None and (isinstance(values, str) or not np.iterable(values)):
                raise ParameterError(f"got {values!r}", expected="a list", at=name)
        arrays = [*field_names(log), *vector_names(log)]
        known = [*arrays, *(name for name, one in recorded_outputs(log).items() if one.shape in ((), (1,)))]
        require_names(self.variables, known, log.variables)
        if (self.times is not None or self.indices is not None) and not self.holds_any(arrays):
            raise ParameterError(
                "none of the variables is a recorded array", hint="leave times and indices out", at="variables"
            )

    def holds_any(self, names: Sequence[str]) -> bool:
        """Tell whether one of these variables is to be shown."""
        return any(self.holds(name) for name in names)

    def holds(self, name: str) -> bool:
        """Tell whether a variable is to be shown."""
        return self.variables is None or name in self.variables


def draw_report(log: Any, choice: Choice, progress: Callable[[float], None]) -> tuple[SceneData, dict[str, Shown]]:
    """Return what a log holds, and its figures by the names of their files, in the order of the page.

    Args:
        log: an open log.
        choice: what to show.
        progress: told the part that is done, 0 to 1.

    Raises:
        ParameterError: as in `Choice.check`, or an instant or a place that the log does not have.
    """
    choice.check(log)
    # Vectors in balances have figures of their own; as arrays they are shown only where they are named.
    in_balances = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    unnamed = in_balances if choice.variables is None else set()
    arrays = [name for name in field_names(log) if choice.holds(name) and name not in unnamed]
    share = 1.0 / (1 + len(arrays))
    scene_data = from_log(log, run_figures.FRAMES, lambda part: progress(share * part))
    drawn: dict[str, Shown] = {}
    if choice.variables is None and (shown := plane.load_plane(log, scene_data, choice.times)) is not None:
        where = "In space" if shown.is_solid else "In the plane"
        drawn["plane"] = Shown(where, plane.draw_plane(shown), f"{plane.words(shown)} {scene_data.remark}".strip())
        drawn |= _further_planes(log, scene_data, shown, choice)
    main = (
        scene_data.motion.colour_variable.name
        if scene_data.motion is not None and scene_data.motion.colour is not None
        else None
    )
    # The states of a surface are seen in its pictures.
    states = {one.state for one in log.drawables if isinstance(one, Cells) and is_solid(one.nodes)}
    arrays = [name for name in arrays if name not in states or choice.variables is not None]
    # What colours the particles comes first and is in memory already.
    share = 1.0 / (1 + len(arrays))
    for place, name in enumerate(sorted(arrays, key=lambda name: name != main), start=1):
        if name == main and scene_data.motion is not None:
            field = as_field(scene_data.motion)
        else:
            field = load_field(log, name, run_figures.FRAMES)
        drawn |= _field_figures(
            field, choice, name == main, place_of_output(log.drawables, name, field.total), scene_data.valid_until
        )
        progress(share * (place + 1))
    moved = {one.displacement for one in log.drawables if isinstance(one, Points | Cells)}
    for name in vector_names(log):
        if name not in moved if choice.variables is None else choice.holds(name):
            drawn[f"{name}-histories"] = _vector_figure(log, name, choice, scene_data.valid_until)
    for balance in scene_data.balances:
        figure = run_figures.balance(scene_data, balance.quantity)
        if figure is not None:
            quantity = balance.quantity.replace("_", " ").capitalize()
            words = (
                f"{quantity} since the reset; below, what the balance cannot account for: "
                f"the error of the numerics, in {balance.unit} at the left, as a part of the largest entry at the right."
            )
            drawn[f"balance-{balance.quantity}"] = Shown("Balances", figure, words)
    if curves := [one for one in _curves(scene_data, "outputs") if choice.holds(one.name)]:
        figure = run_figures.curves(curves, scene_data.valid_until)
        drawn["outputs"] = Shown("Outputs", figure, "Outputs in time; those that stay 0 are left out.")
    drawn |= _input_figures(log, scene_data)
    if choice.variables is None and (happened := log.events()):
        span = log.start_tick * log.step_size, log.start_tick * log.step_size + log.duration
        figure = run_figures.event_counts([(event.tick * log.step_size, event.kind) for event in happened], span)
        drawn["events"] = Shown(
            "Events", figure, "How many events there were, in a hundred equal parts of the run, by their kind."
        )
    return scene_data, drawn


def _further_planes(log: Any, scene_data: SceneData, shown: plane.Plane, choice: Choice) -> dict[str, Shown]:
    """Return pictures of a body in space in the colours of what else was recorded for each of its nodes or cells."""
    drawn: dict[str, Shown] = {}
    surfaces = [one for one in shown.drawables if isinstance(one, Cells) and is_solid(one.nodes)]
    now = {name for one in surfaces for name in (one.field, one.state)}
    for name in colouring_outputs(surfaces, recorded_outputs(log)):
        if name not in now and (other := plane.load_plane(log, scene_data, choice.times, name)) is not None:
            words = f"The same, coloured by {log.variables[name].description}."
            drawn[f"plane-{name}"] = Shown(f"{name.replace('_', ' ').capitalize()}", plane.draw_plane(other), words)
    return drawn


def _field_figures(field: Field, choice: Choice, is_main: bool, drawn_at: Place | None, valid_until: float) -> dict[str, Shown]:
    """Return the figures of one array: of the one that colours the particles all three, of another those without instants.

    What is drawn side by side in a plane has histories alone, unless it is asked for: its numbers do not say where it is.
    """
    things = drawn_at.name.replace("_", " ") if drawn_at is not None and drawn_at.name else f"{field.place}s"
    name = field.variable.name.replace("_", " ")
    stem = "" if is_main else f"{field.variable.name}-"
    sign = "red is positive, blue negative" if field.values.min(initial=0.0) < 0.0 else "the redder the larger"
    if field.variable.unit == "m/s" and field.values.min(initial=0.0) < 0.0:
        sign = "red is to the right, blue to the left"
    across = f"of every {field.place}" if field.coordinate is None else "along x"
    words = (
        f"{name.capitalize()} {across} (across) at every instant (up); {sign}, nearly white is 0. "
        "Where there is no frame the diagram is grey."
    )
    heading = "x-t diagram" if is_main else f"{name.capitalize()}"
    drawn, is_asked = {}, choice.times is not None or choice.variables is not None
    if is_asked or drawn_at is None or not drawn_at.fills_plane:
        drawn[f"{stem}space-time"] = Shown(heading, run_figures.space_time(field), words)
        if is_main or is_asked or field.coordinate is not None:
            heading = "Profiles at chosen times" if is_main else f"{name.capitalize()}: profiles"
            words = f"{name.capitalize()} {across} at chosen instants."
            drawn[f"{stem}profiles"] = Shown(heading, run_figures.profiles(field, choice.times), words)
    heading = f"Histories of chosen {things}" if is_main else f"{name.capitalize()}: histories"
    which = "" if choice.indices is not None else ", evenly spaced among those that changed; others can be named (indices)"
    words = f"{name.capitalize()} of chosen {things} in time{which}."
    drawn[f"{stem}histories"] = Shown(heading, run_figures.histories(field, choice.indices, None, valid_until), words)
    return drawn


def _vector_figure(log: Any, name: str, choice: Choice, valid_until: float) -> Shown:
    """Return histories of vectors at several places, each component in a panel of its own."""
    fields = load_vector_fields(log, name, run_figures.FRAMES)
    figure = run_figures.stack(fields, lambda field, into: run_figures.histories(field, choice.indices, into, valid_until))
    heading = name.replace("_", " ").capitalize()
    return Shown(f"{heading}: histories", figure, f"{heading} at chosen places in time, one component in each panel.")


def _curves(scene_data: SceneData, group: str) -> list[Curve]:
    found = [curve for plot in plots(scene_data) if plot.group == group for curve in plot.curves]
    return [curve for curve in found if np.any(curve.values != 0.0)]


def _input_figures(log: Any, scene_data: SceneData) -> dict[str, Shown]:
    """Return a figure of the inputs that are one number, and one of each array that acts; of many elements x-t diagrams too."""
    drawn: dict[str, Shown] = {}
    scalars = {name for name, one in log.input_variables.items() if one.shape == ()}
    if curves := [one for one in _curves(scene_data, "inputs") if one.name in scalars]:
        drawn["inputs"] = Shown("Inputs", run_figures.curves(curves), "Inputs in time; those that stay 0 are left out.")
    for name in log.input_variables:
        acted = None if name in scalars else load_input(log, name)
        if acted is None or not acted.acts:
            continue
        moving = [one for one in acted.curves if one.values.any()]
        drawn[f"inputs-{name}"] = Shown("Inputs", run_figures.curves(moving), _input_words(acted))
        shape = acted.variable.shape
        # The numbers of what lies side by side in a plane do not say where it is.
        place = place_of_output(log.drawables, name, shape[0])
        if not acted.is_summary or (place is not None and place.fills_plane):
            continue
        fields = [one for one in load_input_fields(log, name, run_figures.FRAMES) if one.values.any()]
        figure = run_figures.stack(fields, lambda field, into: run_figures.space_time(field, into=into))
        across = "along x" if fields[0].coordinate is not None else f"of every {fields[0].place}"
        words = f"{name.replace('_', ' ').capitalize()} {across} (across) at every instant (up)."
        drawn[f"inputs-{name}-space-time"] = Shown("Inputs", figure, words)
    return drawn


def _input_words(acted: InputCurves) -> str:
    """Return what an array input is, what the numbers of its elements count, and which of them are seen."""
    variable, size = acted.variable, math.prod(acted.variable.shape)
    words = f"{variable.name.replace('_', ' ').capitalize()} in time: {variable.description}."
    if variable.axes and any("[" in curve.name for curve in acted.curves):
        counted = [_axis_words(*one) for one in zip(variable.axes, variable.shape, strict=True)]
        words += f" In brackets: {', '.join(counted)}."
    if acted.is_summary:
        return f"{words} {acted.acting} of {size} elements act; the curves are the largest and the least of all elements."
    if acted.acting < size:
        return (
            f"{words} {acted.acting} of {size} elements act{'s' if acted.acting == 1 else ''}; those that stay 0 are left out."
        )
    return words if len(acted.curves) > 1 or size == 1 else f"{words} It is the same for all {size} elements."


def _axis_words(axis: str, size: int) -> str:
    """Return what the numbers along an axis count."""
    if axis == "direction" and size <= len(_DIRECTIONS):
        return f"direction ({', '.join(f'{number} is {name}' for number, name in enumerate(_DIRECTIONS[:size]))})"
    return axis.replace("_", " ")
