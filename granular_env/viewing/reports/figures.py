"""The figures of a report: every recorded array and scalar, except those that are always zero or visible in the pictures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import prod
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from granular_env.components.drawables import Cells, Points
from granular_env.components.errors import ParameterError
from granular_env.recording.preview.visible_drawables import colouring_outputs, is_plane_filling, is_solid

from ..curves import MOST_CURVES, InputCurves, load_input_curves
from ..figures import plane, run_figures
from ..recorded_fields import curve_names, load_curves, load_fields, recorded_outputs
from ..scene_builder import load_scene
from ..scene_data import SceneData

_CAPTIONS = {"space-time": "x-t diagram", "profiles": "Profiles", "histories": "Histories"}


class CaptionedFigure(NamedTuple):
    """A figure of a page with the heading of its section and its caption."""

    heading: str
    figure: Figure
    words: str


class ReportChoice(NamedTuple):
    """The user's choice of what a report shows: names of variables, times [s] and indices of elements; None for the default."""

    variables: Sequence[str] | None = None
    times: Sequence[float] | None = None
    indices: Sequence[int] | None = None


def draw_report(
    log: Any, choice: ReportChoice, progress: Callable[[float], None]
) -> tuple[SceneData, dict[str, CaptionedFigure], list[str]]:
    """Return a log's scene data, its figures by file name in the order of the page, and sentences on outputs without a figure.

    `progress` gets the done fraction.

    Raises:
        ParameterError: a variable, time or place that the log does not contain.
    """
    names = _chosen_outputs(log, choice)
    scene_data = load_scene(log, run_figures.FRAMES)
    zero = [name for name in names if not any(log.frames(row, name)[1].any() for row in log.frame_rows(name))]
    is_whole = choice.variables is None
    drawn = _scene_pictures(log, scene_data, choice.times, zero) if is_whole else {}
    pictured = [name for name in _pictured_arrays(log) if is_whole and name not in zero]
    shown = [name for name in names if name not in zero and name not in pictured]
    main = next((one.colour_variable.name for one in scene_data.motions[:1] if one.colour is not None), "")
    arrays = [name for name in shown if not curve_names(log.variables[name])]
    arrays.sort(key=lambda name: (len(log.variables[name].shape) > 1, name != main))
    for done, name in enumerate(arrays, start=1):
        progress(done / (1 + len(arrays)))
        drawn |= _array_figures(log, scene_data, name, choice, name == main)
    drawn |= _balance_figures(scene_data)
    if curves := [curve for name in shown if name not in arrays for curve in load_curves(log, name)]:
        figure = run_figures.draw_curve_panels(curves, scene_data.valid_until)
        drawn["outputs"] = CaptionedFigure("Outputs", figure, "Outputs over time.")
    drawn |= _input_figures(log)
    if is_whole and (happened := log.events()):
        span = log.start_tick * log.step_size, log.start_tick * log.step_size + log.duration
        figure = run_figures.draw_event_counts([(event.tick * log.step_size, event.kind) for event in happened], span)
        drawn["events"] = CaptionedFigure("Events", figure, "Number of events of each kind in each hundredth of the run.")
    omissions = [f"Always zero: {', '.join(zero)}."] if zero else []
    if pictured:
        options = " ".join(f"--variables {name}" for name in pictured)
        omissions.append(f"Shown in the pictures alone: {', '.join(pictured)}. The curves are shown by {options}.")
    return scene_data, drawn, omissions


def _chosen_outputs(log: Any, choice: ReportChoice) -> list[str]:
    """Return the recorded outputs to show, by default all except the entries of balances."""
    recorded = recorded_outputs(log)
    balanced = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    names = [name for name in recorded if name not in balanced] if choice.variables is None else list(choice.variables)
    if unknown := [name for name in names if name not in recorded]:
        known = f"this log contains {', '.join(recorded) or 'none'}"
        raise ParameterError(f"{unknown[0]!r} was not recorded", hint=known, at="variables")
    if (choice.times or choice.indices) and all(curve_names(recorded[name]) for name in names):
        raise ParameterError("none of the variables is a recorded array", hint="omit times and indices", at="variables")
    return names


def _scene_pictures(
    log: Any, scene_data: SceneData, times: Sequence[float] | None, zero: Collection[str]
) -> dict[str, CaptionedFigure]:
    """Return pictures of a plane or a body in space; for a surface, one per output that can colour it."""
    if (shown := plane.load_plane(log, scene_data, times)) is None:
        return {}
    heading, words = "In space" if scene_data.is_solid else "In the plane", f"{plane.plane_text(shown)} {scene_data.remark}"
    drawn = {"plane": CaptionedFigure(heading, plane.draw_plane(shown), words.strip())}
    surfaces = [one for one in log.drawables if isinstance(one, Cells) and is_solid(one.nodes)]
    excluded = {*zero, *(mesh.field_variable.name for mesh in shown.scene.meshes), *(one.state for one in surfaces)}
    for name in colouring_outputs(surfaces, recorded_outputs(log)):
        other = None if name in excluded else plane.load_plane(log, scene_data, times, name)
        if other is not None:
            words = f"The same, coloured by {log.variables[name].description}."
            drawn[f"plane-{name}"] = CaptionedFigure(figure_title(name), plane.draw_plane(other), words)
    return drawn


def _pictured_arrays(log: Any) -> list[str]:
    """Return the arrays that only the pictures show: displacements, and the states of the cells of surfaces."""
    recorded, bodies = recorded_outputs(log), [one for one in log.drawables if isinstance(one, Points | Cells)]
    states = [one.state for one in bodies if isinstance(one, Cells) and is_solid(one.nodes)]
    names = dict.fromkeys([*states, *(one.displacement for one in bodies)])
    return [name for name in names if name in recorded and (name in states or len(recorded[name].shape) > 1)]


def _array_figures(
    log: Any, scene_data: SceneData, name: str, choice: ReportChoice, is_main: bool
) -> dict[str, CaptionedFigure]:
    """Return the figures of an array: x-t diagram, profiles (of the main array or on request) and histories.

    Vectors have only histories. The same holds, unless requested, for values at places that fill a plane, because the
    number of such a place does not determine its position.
    """
    fields, variable = load_fields(log, name, run_figures.FRAMES), log.variables[name]
    field, title, kinds = fields[0], figure_title(name), ["histories"]
    is_asked = choice.variables is not None
    # An image of a few columns shows less than their curves.
    is_few = field.total <= MOST_CURVES and field.coordinate is None
    is_line = is_asked or field.coordinate is not None or not is_plane_filling(log.drawables, field.total)
    if is_line and not is_few and len(variable.shape) == 1:
        has_profiles = is_main or is_asked or choice.times is not None or field.coordinate is not None
        kinds = ["space-time", "profiles", "histories"] if has_profiles else ["space-time", "histories"]
    indices = range(field.total) if is_few and choice.indices is None else choice.indices
    picked = "" if indices is not None else " The elements are evenly spaced among those that changed."
    notes = {"space-time": " Times without a frame are grey.", "histories": picked}
    drawn = {}
    for kind in kinds:
        figure = run_figures.draw_fields(fields, kind, choice.times, indices, scene_data.valid_until)
        words = f"{_CAPTIONS[kind]}: {variable.description}.{notes.get(kind, '')}"
        drawn[f"{name}-{kind}"] = CaptionedFigure(title, figure, words)
    return drawn


def _balance_figures(scene_data: SceneData) -> dict[str, CaptionedFigure]:
    drawn = {}
    for balance in scene_data.balances:
        if (figure := run_figures.draw_balance(scene_data, balance.quantity)) is not None:
            words = f"{figure_title(balance.quantity)} since the reset and, unless it is 0, the residual: the numerical error."
            drawn[f"balance-{balance.quantity}"] = CaptionedFigure("Balances", figure, words)
    return drawn


def _input_figures(log: Any) -> dict[str, CaptionedFigure]:
    """Return a figure of each input that is not always 0; large arrays also as x-t diagram."""
    drawn: dict[str, CaptionedFigure] = {}
    for name in log.input_variables:
        acted = load_input_curves(log, name)
        moving = [] if acted is None else [one for one in acted.curves if one.values.any()]
        if acted is None or not moving:
            continue
        drawn[f"inputs-{name}"] = CaptionedFigure("Inputs", run_figures.draw_curve_panels(moving), _input_text(acted))
        if acted.is_summary and not is_plane_filling(log.drawables, acted.variable.shape[0]):
            fields = [one for one in load_fields(log, name, run_figures.FRAMES) if one.values.any()]
            words = f"x-t diagram: {acted.variable.description}."
            drawn[f"inputs-{name}-space-time"] = CaptionedFigure("Inputs", run_figures.draw_fields(fields, "space-time"), words)
    return drawn


def _input_text(acted: InputCurves) -> str:
    """Return the caption of an input's figure: its description and, for an array, which elements are drawn."""
    variable, size = acted.variable, prod(acted.variable.shape)
    words = f"{figure_title(variable.name)} over time: {variable.description}."
    if size == 1:
        return words
    if len(acted.curves) == 1 and acted.acting == size:
        return f"{words} All {size} elements have the same value."
    summary = "the curves are the maximum and the minimum over all elements"
    shown = summary if acted.is_summary else "elements that stay 0 are omitted"
    return f"{words} {acted.acting} of {size} elements act; {shown}."


def figure_title(name: str) -> str:
    """Return the name of a variable as a heading."""
    return name.replace("_", " ").capitalize()
