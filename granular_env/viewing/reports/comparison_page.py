"""The page for two logs: their first difference, the settings that differ, and figures that show both logs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from granular_env.components.support.float_arrays import FloatArray
from granular_env.progress import Progress, progress_bar
from granular_env.recording.comparison import LogComparison, common_frames, compare_logs

from ..curves import MOST_CURVES, Curve, component_names, load_input_curves
from ..figures import plane
from ..figures.colour_bar import add_colour_bar
from ..figures.drawing import draw_curves, new_figure, place_name, use_style
from ..figures.run_figures import FRAMES, draw_fields
from ..html_page import Page, parts
from ..recorded_fields import Field, curve_names, load_curves, load_fields, pick_evenly, sample_frames
from ..scene_builder import load_scene, require_log
from ..scene_data import MAXIMUM_POINTS
from ..scene_scales import make_scales
from ..unit_labels import label_with_unit, typeset_unit
from ..visible_drawables import is_plane_filling
from .figures import CaptionedFigure
from .page import figure_sections, require_page, write_page
from .tables import short_value

Logs = tuple[Any, Any]
PAGE = "compare.html"
_NAMES = ("A", "B")
# Number of instants of the pictures, and of places of the histories.
_INSTANTS, _PLACES = 3, 3
# Histories are drawn of places at which the logs differ by at least this fraction of the largest difference.
_CLEAR = 0.05


def compare(
    first: Any, second: Any, folder: str | os.PathLike[str], progress: Progress = False, file_format: str = "png"
) -> Path:
    """Write ``compare.html`` for two logs of one component, and its figures as files.

        ge.viewing.compare(log, branch, "comparison")

    The page states the first difference bit for bit, and lists the settings that differ. Figures overlay the outputs and
    inputs that differ, and show both logs at the same instants with one scale.

    Args:
        first: an open log, called A on the page.
        second: an open log, called B.
        folder: target folder; it is created if necessary.
        progress: show a bar, or call this with the completed fraction.
        file_format: format of the figures' files: "png", "svg" or "pdf".

    Returns:
        The path of the page.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: the logs have different components, another format, or `folder` is a file; nothing is written.
        GranularError: the files cannot be written; none is written.
    """
    require_log(first)
    require_log(second)
    require_page(Path(folder) / PAGE, file_format)
    return write_comparison((first, second), compare_logs(first, second), Path(folder) / PAGE, progress, file_format)


def write_comparison(logs: Logs, found: LogComparison, target: Path, progress: Progress, file_format: str) -> Path:
    """Write the page `target` on the differences between two logs; see `compare`."""
    with progress_bar(f"comparison in {target.parent.name}", show=progress) as bar:
        drawn = _draw_pictures(logs, found) | _draw_curves(logs, found)
        names = list(dict.fromkeys(one.variable for one in found.differences if one.kind == "output"))
        for done, name in enumerate(names):
            bar.update(done / len(names))
            drawn |= _draw_array(logs, name)
        tables = [("First differences", _difference_table(found)), ("Settings", _setting_table(found))]
        title = f"Comparison: {' and '.join(log.path.name for log in logs)}"
        write_page(target, Page(title, _lead(logs, found), [*tables, *figure_sections(drawn)]), drawn, file_format)
        bar.update(1.0)
    return target


def _lead(logs: Logs, found: LogComparison) -> Markup:
    message = f"{found.message[0].upper()}{found.message[1:]}."
    files = [f"{name}: {log.path}, {log.metadata.get('created')}" for name, log in zip(_NAMES, logs, strict=True)]
    return parts.paragraph(message) + parts.bullets([*files, *filter(None, [found.relation])], "dim")


def _difference_table(found: LogComparison) -> Markup:
    rows = []
    for one in found.differences:
        element = ", ".join(map(str, one.index))
        largest = "" if one.largest is None else f"{one.largest:.4g}"
        name, unit = one.variable.replace("_", " "), typeset_unit(one.unit)
        rows.append([one.kind, name, unit, one.time, element, *_distinct_texts(one.values), largest])
    differ = {one.variable for one in found.differences}
    equal = [name.replace("_", " ") for name in found.compared if name not in differ]
    words = [f"Equal at all common times: {', '.join(equal)}."] if equal else []
    if found.not_compared:
        words.append(f"Not compared, because only one log contains them or the shapes differ: {', '.join(found.not_compared)}.")
    heads = ["kind", "name", "unit", "time [s]", "element", "A", "B", "largest difference"]
    table = parts.table(heads, rows) if rows else Markup()
    return table + Markup().join(map(parts.paragraph, words))


def _distinct_texts(values: tuple[float, float]) -> tuple[str, str]:
    """Return two numbers with six digits or, if these are equal, with more."""
    texts = ((f"{values[0]:.{digits}g}", f"{values[1]:.{digits}g}") for digits in (6, 9, 12, 17))
    return next((pair for pair in texts if pair[0] != pair[1]), (repr(values[0]), repr(values[1])))


def _setting_table(found: LogComparison) -> Markup:
    if not found.settings:
        return parts.paragraph("All settings are equal.")
    rows = [[one.group, one.name, *map(short_value, one.values)] for one in found.settings]
    return parts.table(["group", "setting", "A", "B"], rows)


def _draw_curves(logs: Logs, found: LogComparison) -> dict[str, CaptionedFigure]:
    """Draw the inputs and the scalar outputs that differ, both logs in one panel."""
    drawn, residuals = {}, {balance.residual for balance in logs[0].balances}
    for kind, read in (("input", _input_curves), ("output", _scalar_curves)):
        names = [one.variable for one in found.differences if one.kind == kind and one.variable not in residuals]
        panels = [panel for name in names for panel in _pair_curves([read(log, name) for log in logs])]
        if panels:
            words = f"{kind.capitalize()}s that differ, over time; residuals of balances are omitted."
            drawn[f"{kind}s"] = CaptionedFigure(f"{kind.capitalize()}s", draw_overlays(panels), words)
    return drawn


def _input_curves(log: Any, name: str) -> Sequence[Curve]:
    acted = load_input_curves(log, name)
    return () if acted is None else acted.curves


def _scalar_curves(log: Any, name: str) -> Sequence[Curve]:
    return list(load_curves(log, name)) if curve_names(log.variables[name]) else ()


def _pair_curves(curves: Sequence[Sequence[Curve]]) -> list[tuple[str, list[Curve]]]:
    """Return for each curve its label and the curves of both logs, which are named A and B."""
    pairs: dict[str, list[Curve]] = {}
    for name, own in zip(_NAMES, curves, strict=True):
        for one in own:
            pairs.setdefault(label_with_unit(one.name, one.unit), []).append(replace(one, name=name))
    return list(pairs.items())


@use_style
def draw_overlays(panels: Sequence[tuple[str, Sequence[Curve]]]) -> Figure:
    """Draw panels with a label and curves named A and B, one above the other."""
    figure = new_figure(8.0, 0.6 + 2.2 * len(panels))
    for axes, (label, curves) in zip(figure.subplots(len(panels), 1, sharex=True, squeeze=False).flat, panels, strict=True):
        draw_curves(axes, curves, label)
        axes.label_outer()
    return figure


def _draw_array(logs: Logs, name: str) -> dict[str, CaptionedFigure]:
    """Draw histories of a recorded array that differs, and of values along a row an x-t diagram of the differences."""
    variable = logs[0].variables[name]
    if curve_names(variable):
        return {}
    differences, title = _difference_fields(logs, name), name.replace("_", " ").capitalize()
    fields = [load_fields(log, name, FRAMES) for log in logs]
    panels = []
    for place, difference in enumerate(differences):
        for column in _differing_columns(difference.values):
            own = [replace(_column_curve(field[place], column), name=side) for side, field in zip(_NAMES, fields, strict=True)]
            panels.append((f"{fields[0][place].label}\n{place_name(difference, column)}", own))
    words = f"{title} of up to {_PLACES} elements at which the logs clearly differ."
    drawn = {f"{name}-histories": CaptionedFigure(f"{title}: histories", draw_overlays(panels), words)}
    is_line = differences[0].coordinate is not None or not is_plane_filling(logs[0].drawables, differences[0].total)
    if is_line and len(differences) == 1 and differences[0].total > MOST_CURVES:
        words = f"{title} in B minus that in A, along the elements (horizontal) and over time (vertical)."
        drawn[f"{name}-difference"] = CaptionedFigure(f"{title}: difference", draw_fields(differences, "space-time"), words)
    return drawn


def _difference_fields(logs: Logs, name: str) -> list[Field]:
    """Return an array of B minus that of A at common times, with one field for each component of a vector."""
    frames = common_frames(logs, name)
    fields = load_fields(logs[0], name, 2)
    count, every = len(component_names(logs[0].variables[name])), fields[0].every
    most = max(2, min(FRAMES, MAXIMUM_POINTS // max(1, prod(logs[0].variables[name].shape) // every)))
    picked = pick_evenly(len(frames[0]), most)
    (times, before), (_, after) = (sample_frames(log, name, own[picked]) for log, own in zip(logs, frames, strict=True))
    values = (after - before).reshape(len(times), -1, count)[:, ::every]
    found = []
    for place, one in enumerate(fields):
        variable = replace(one.variable, name=f"{one.variable.name}, B - A")
        found.append(replace(one, variable=variable, times=times, values=values[:, :, place], cuts=one.cuts[:0]))
    return found


def _differing_columns(values: FloatArray) -> list[int]:
    """Return up to `_PLACES` columns of differences, shape (frames, n), evenly spaced among those that are clearly not zero."""
    largest = np.nanmax(np.abs(values), axis=0, initial=0.0)
    clear = np.flatnonzero(largest >= max(_CLEAR * largest.max(initial=0.0), 1e-300))
    return [] if not len(clear) else clear[pick_evenly(len(clear), _PLACES)].tolist()


def _column_curve(field: Field, column: int) -> Curve:
    ticks = np.zeros(len(field.times), np.int64)
    return Curve(field.variable.name, field.variable.unit, "", field.times, ticks, field.values[:, column], field.cuts)


def _draw_pictures(logs: Logs, found: LogComparison) -> dict[str, CaptionedFigure]:
    """Draw the bodies of both logs at the same instants after their first difference, with common scales."""
    scenes = [load_scene(log, 2) for log in logs]
    if not found.differences or not all(one.is_plane for one in scenes):
        return {}
    start = max(found.differences[0].time, *(one.shapes[0].times[0] for one in scenes))
    end = min(one.shapes[0].times[-1] for one in scenes)
    times = np.linspace(start, max(start, end), _INSTANTS + 1)[1:].tolist()
    loaded = [plane.load_plane(log, scene, times) for log, scene in zip(logs, scenes, strict=True)]
    planes = [one for one in loaded if one is not None]
    shared = replace(
        planes[0].scene,
        motions=tuple(one for own in planes for one in own.scene.motions),
        meshes=tuple(one for own in planes for one in own.scene.meshes),
    )
    scales = make_scales(shared)
    if len(planes) < len(logs) or scales is None:
        return {}
    planes = [plane.Plane(one.scene, scales) for one in planes]
    words = f"A on the left and B on the right, with one scale. {plane.plane_text(planes[0])}"
    return {"plane": CaptionedFigure("Pictures", _draw_side_by_side(planes), words)}


@use_style
def _draw_side_by_side(planes: Sequence[plane.Plane]) -> Figure:
    rows = min(len(one.times) for one in planes)
    low, high = np.min([one.bounding_box[0] for one in planes], axis=0), np.max([one.bounding_box[1] for one in planes], axis=0)
    width, height = (high - low).tolist()
    bars = planes[0].scales.colours
    figure = new_figure(8.0, rows * min(4.0 * height / width + 0.35, 4.5) + 0.7 * len(bars))
    panels = figure.subplots(rows, len(planes), squeeze=False)
    for column, (name, one) in enumerate(zip(_NAMES, planes, strict=True)):
        for frame, axes in enumerate(panels[:, column]):
            plane.draw_instant(axes, one, frame)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            axes.set_title(f"{name}, t = {plane.instant_text(one, frame)}", fontsize=11)
    figure.supxlabel(plane.exaggeration_text(planes[0]), x=0.0, horizontalalignment="left", fontsize=10)
    for bar in bars:
        add_colour_bar(figure, bar, ax=panels, shrink=0.5, aspect=40, pad=0.02)
    return figure
