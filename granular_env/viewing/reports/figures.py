"""The figures of a report: every recorded array and scalar, except those that are always zero or visible in the pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from granular_env.components.drawables import Cells, Links, Points, element_count
from granular_env.components.errors import ParameterError
from granular_env.recording.preview.visible_drawables import colouring_outputs, is_plane_filling, is_solid

from ..curves import MOST_CURVES, Curve, InputCurves, load_input_curves
from ..figures import plane, run_figures
from ..plot_groups import make_plots
from ..recorded_fields import Field, array_names, load_fields, recorded_outputs
from ..scene_builder import load_scene
from ..scene_data import SceneData


@dataclass(frozen=True)
class CaptionedFigure:
    """A figure of a report with its heading and its caption."""

    heading: str
    figure: Figure
    words: str


@dataclass(frozen=True)
class ReportChoice:
    """The user's choice of what a report shows: names of variables, times [s] and indices of elements; None for the default."""

    variables: Sequence[str] | None = None
    times: Sequence[float] | None = None
    indices: Sequence[int] | None = None

    def check_log(self, log: Any) -> None:
        """Raise `ParameterError` if the log does not contain the chosen variables, times or indices."""
        arrays = array_names(log)
        known = [*arrays, *(name for name in recorded_outputs(log) if name not in arrays)]
        if unknown := [name for name in self.variables or () if name not in known]:
            raise ParameterError(
                f"{unknown[0]!r} was not recorded", hint=f"this log contains {', '.join(known) or 'none'}", at="variables"
            )
        if (self.times is not None or self.indices is not None) and not any(map(self.is_chosen, arrays)):
            raise ParameterError("none of the variables is a recorded array", hint="omit times and indices", at="variables")

    def is_chosen(self, name: str) -> bool:
        """Return whether the report shows a variable."""
        return self.variables is None or name in self.variables


def draw_report(
    log: Any, choice: ReportChoice, progress: Callable[[float], None]
) -> tuple[SceneData, dict[str, CaptionedFigure], list[str]]:
    """Return a log's scene data, its figures by file name in the order of the page, and sentences on outputs without a figure.

    `progress` gets the done fraction.

    Raises:
        ParameterError: as in `ReportChoice.check_log`, or a time or place outside the log.
    """
    choice.check_log(log)
    scene_data = load_scene(log, run_figures.FRAMES)
    balanced = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    others = [name for name in recorded_outputs(log) if choice.is_chosen(name) and name not in balanced]
    zero = [name for name in others if is_always_zero(log, name)]
    drawn = _scene_pictures(log, scene_data, choice, zero) if choice.variables is None else {}
    pictured = _pictured_arrays(log) if choice.variables is None else {}
    elsewhere = {*pictured, *zero, *(balanced if choice.variables is None else ())}
    main = _main_array(scene_data)
    arrays = [name for name in array_names(log) if choice.is_chosen(name) and name not in elsewhere]
    arrays.sort(key=lambda name: (len(log.variables[name].shape) > 1, name != main))
    for done, name in enumerate(arrays, start=1):
        progress(done / (1 + len(arrays)))
        drawn |= _array_figures(log, scene_data, name, choice)
    drawn |= _balance_figures(scene_data)
    if curves := [one for one in _active_curves(scene_data, "outputs") if choice.is_chosen(one.name)]:
        figure = run_figures.draw_curve_panels(curves, scene_data.valid_until)
        drawn["outputs"] = CaptionedFigure("Outputs", figure, "Outputs over time.")
    drawn |= _input_figures(log, scene_data)
    if choice.variables is None and (happened := log.events()):
        span = log.start_tick * log.step_size, log.start_tick * log.step_size + log.duration
        figure = run_figures.draw_event_counts([(event.tick * log.step_size, event.kind) for event in happened], span)
        drawn["events"] = CaptionedFigure("Events", figure, "Number of events of each kind in each hundredth of the run.")
    return scene_data, drawn, list(_omission_sentences(pictured, zero))


def is_always_zero(log: Any, name: str) -> bool:
    """Return whether all recorded values of an output are zero."""
    return not any(log.frames(row, name)[1].any() for row in log.frame_rows(name))


def _omission_sentences(pictured: Mapping[str, str], zero: Sequence[str]) -> Iterator[str]:
    """Yield sentences on outputs that are always zero, and on those that the pictures show."""
    if zero:
        yield f"Always zero: {', '.join(name.replace('_', ' ') for name in zero)}."
    if elsewhere := {name: how for name, how in pictured.items() if name not in zero}:
        words = ", ".join(f"{name.replace('_', ' ')} ({how})" for name, how in elsewhere.items())
        yield f"Not shown as curves: {words}; show them with {' '.join(f'--variables {name}' for name in elsewhere)}."


def _scene_pictures(log: Any, scene_data: SceneData, choice: ReportChoice, zero: Collection[str]) -> dict[str, CaptionedFigure]:
    """Return pictures of a plane or a body in space; for a surface, one per output that can colour it."""
    if (shown := plane.load_plane(log, scene_data, choice.times)) is None:
        return {}
    heading = "In space" if scene_data.is_solid else "In the plane"
    caption = f"{plane.plane_text(shown)} {scene_data.remark}".strip()
    drawn = {"plane": CaptionedFigure(heading, plane.draw_plane(shown), caption)}
    surfaces = [one for one in log.drawables if isinstance(one, Cells) and is_solid(one.nodes)]
    shown_already = {mesh.field_variable.name for mesh in shown.scene.meshes} | {one.state for one in surfaces}
    for name in colouring_outputs(surfaces, recorded_outputs(log)):
        is_new = name not in shown_already and name not in zero
        other = plane.load_plane(log, scene_data, choice.times, name) if is_new else None
        if other is not None:
            words = f"The same, coloured by {log.variables[name].description}."
            drawn[f"plane-{name}"] = CaptionedFigure(figure_title(name), plane.draw_plane(other), words)
    return drawn


def _pictured_arrays(log: Any) -> dict[str, str]:
    """Return the arrays that only the pictures show, and how."""
    arrays, found = array_names(log), dict[str, str]()
    for one in log.drawables:
        if isinstance(one, Cells) and is_solid(one.nodes):
            found[one.state] = "gaps in the pictures"
        if isinstance(one, Points | Cells) and one.displacement in arrays and len(log.variables[one.displacement].shape) > 1:
            found[one.displacement] = "in the pictures"
    return {name: how for name, how in found.items() if name in arrays}


def _main_array(scene_data: SceneData) -> str:
    """Return the name of the output that colours the first particles; "" if there is none."""
    motion = scene_data.motion
    return "" if motion is None or motion.colour is None else motion.colour_variable.name


def _array_figures(log: Any, scene_data: SceneData, name: str, choice: ReportChoice) -> dict[str, CaptionedFigure]:
    """Return the figures of an array: x-t diagram, profiles (of the main array or on request) and histories.

    Vectors have only histories. The same holds, unless requested, for values at places that fill a plane, because the
    number of such a place does not determine its position.
    """
    fields = load_fields(log, name, run_figures.FRAMES)
    field, is_vector = fields[0], len(log.variables[name].shape) > 1
    is_main, is_asked = name == _main_array(scene_data), choice.times is not None or choice.variables is not None
    title, drawn = figure_title(name), {}
    stem = "" if is_main else f"{name}-"
    across = _axis_text(field)
    # An image of a few columns shows less than their curves.
    is_few = field.total <= MOST_CURVES and field.coordinate is None
    is_line = field.coordinate is not None or not is_plane_filling(log.drawables, field.total)
    if not is_vector and not is_few and (is_asked or is_line):
        words = (
            f"{title} {across} (horizontal) over time (vertical): red is positive, blue is negative, near white is 0. "
            "Times without a frame are grey."
        )
        figure = run_figures.draw_fields(fields, "space-time")
        drawn[f"{stem}space-time"] = CaptionedFigure("x-t diagram" if is_main else title, figure, words)
        if is_main or is_asked or field.coordinate is not None:
            figure = run_figures.draw_fields(fields, "profiles", choice.times)
            heading = "Profiles at chosen times" if is_main else f"{title}: profiles"
            drawn[f"{stem}profiles"] = CaptionedFigure(heading, figure, f"{title} {across} at chosen instants.")
    things = _plural_noun(log, field)
    indices, words = choice.indices, f"{title} of chosen {things} over time, by default evenly spaced among those that changed."
    if is_few:
        indices, words = range(field.total), f"{title} of every {field.place} over time."
    figure = run_figures.draw_fields(fields, "histories", None, indices, scene_data.valid_until)
    heading = f"Histories of chosen {things}" if is_main else f"{title}: histories"
    drawn[f"{stem}histories"] = CaptionedFigure(heading, figure, words)
    return drawn


def _axis_text(field: Field) -> str:
    return f"of every {field.place}" if field.coordinate is None else "along x"


def _plural_noun(log: Any, field: Field) -> str:
    """Return the plural name of an array's places, such as "grains"."""
    drawn = (one for one in log.drawables if isinstance(one, Points | Links) and element_count(one) == field.total)
    return next((one.name.replace("_", " ") for one in drawn), f"{field.place}s")


def _balance_figures(scene_data: SceneData) -> dict[str, CaptionedFigure]:
    drawn = {}
    for balance in scene_data.balances:
        if (figure := run_figures.draw_balance(scene_data, balance.quantity)) is not None:
            residual = "; below, the residual, which is the numerical error" if len(figure.axes) > 1 else ""
            words = f"{figure_title(balance.quantity)} since the reset{residual}."
            drawn[f"balance-{balance.quantity}"] = CaptionedFigure("Balances", figure, words)
    return drawn


def _active_curves(scene_data: SceneData, group: str) -> list[Curve]:
    found = [curve for plot in make_plots(scene_data) if plot.group == group for curve in plot.curves]
    return [curve for curve in found if np.any(curve.values != 0.0)]


def _input_figures(log: Any, scene_data: SceneData) -> dict[str, CaptionedFigure]:
    """Return one figure of all scalar inputs and one per array input that is not always 0; large arrays also as x-t diagram."""
    drawn: dict[str, CaptionedFigure] = {}
    scalars = {name for name, one in log.input_variables.items() if one.shape == ()}
    if curves := [one for one in _active_curves(scene_data, "inputs") if one.name in scalars]:
        drawn["inputs"] = CaptionedFigure(
            "Inputs", run_figures.draw_curve_panels(curves), "Inputs over time; inputs that stay 0 are omitted."
        )
    for name in log.input_variables:
        acted = None if name in scalars else load_input_curves(log, name)
        moving = [] if acted is None else [one for one in acted.curves if one.values.any()]
        if acted is None or not moving:
            continue
        drawn[f"inputs-{name}"] = CaptionedFigure("Inputs", run_figures.draw_curve_panels(moving), _input_text(acted))
        if acted.is_summary and not is_plane_filling(log.drawables, acted.variable.shape[0]):
            fields = [one for one in load_fields(log, name, run_figures.FRAMES) if one.values.any()]
            words = f"{figure_title(name)} {_axis_text(fields[0])} (horizontal) over time (vertical)."
            drawn[f"inputs-{name}-space-time"] = CaptionedFigure("Inputs", run_figures.draw_fields(fields, "space-time"), words)
    return drawn


def _input_text(acted: InputCurves) -> str:
    """Return the caption of an array input's figure: its description, what its indices count, and which elements are drawn."""
    variable = acted.variable
    words = f"{figure_title(variable.name)} in time: {variable.description}."
    if variable.axes:
        numbers = ", ".join(f"{number} is {axis}" for number, axis in enumerate("xyz"[: variable.shape[-1]]))
        counted = (axis.replace("_", " ") + (f" ({numbers})" if axis == "direction" else "") for axis in variable.axes)
        words += f" In brackets: {', '.join(counted)}."
    size = math.prod(variable.shape)
    if len(acted.curves) == 1 and acted.acting == size:
        return f"{words} All {size} elements have the same value."
    shown = (
        "the curves are the maximum and the minimum over all elements"
        if acted.is_summary
        else "elements that stay 0 are omitted"
    )
    return f"{words} {acted.acting} of {size} elements act; {shown}."


def figure_title(name: str) -> str:
    """Return the name of a variable as a heading."""
    return name.replace("_", " ").capitalize()
