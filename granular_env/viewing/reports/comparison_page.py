"""The page for two logs: their first differences, the settings that differ, and figures that show both logs."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from granular_env.components.support.float_arrays import FloatArray
from granular_env.progress import Progress, progress_bar
from granular_env.recording.comparison import Difference, LogComparison, Logs, common_frames, compare_logs
from granular_env.recording.preview.visible_drawables import is_plane_filling

from ..curves import MOST_CURVES, Curve, component_names, load_input_curves
from ..figures.plane import Plane, draw_plane, plane_text
from ..figures.run_figures import FRAMES, default_indices, draw_curve_panels, draw_fields
from ..html_page import Page, parts
from ..recorded_fields import Field, curve_names, load_curves, load_fields, pick_evenly, sample_frames
from ..scene_builder import load_scene, load_shapes, require_log
from ..scene_data import MAXIMUM_POINTS, SceneData
from ..scene_scales import make_scales
from ..unit_labels import typeset_unit
from .figures import CaptionedFigure, figure_title
from .page import figure_sections, require_page, write_page
from .tables import short_value

_NAMES = ("A", "B")
# Number of instants of the pictures, and distance between the bodies of both logs, as a fraction of their width.
_INSTANTS, _GAP = 3, 0.1


def compare(
    first: Any, second: Any, folder: str | os.PathLike[str], progress: Progress = False, file_format: str = "png"
) -> LogComparison:
    """Write ``compare.html`` for two logs of one component, and its figures as files.

        ge.viewing.compare(log, branch, "comparison").message

    The page states the first differences, bit for bit, and the settings that differ. Figures show the inputs and outputs that
    differ in the same axes, and bodies in a plane or in space at the same instants with one scale.

    Args:
        first: an open log, called A on the page.
        second: an open log, called B.
        folder: target folder; it is created if necessary.
        progress: show a bar, or call this with the completed fraction.
        file_format: format of the figures' files: "png", "svg" or "pdf".

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: the logs have different components, another format, or `folder` is a file; nothing is written.
        GranularError: the files cannot be written; none is written.
    """
    require_log(first)
    require_log(second)
    logs, target = (first, second), Path(folder) / "compare.html"
    require_page(target, file_format)
    with progress_bar(f"comparison in {target.parent.name}", show=progress) as bar:
        found = compare_logs(first, second)
        drawn = _draw_bodies(logs, found.differences)
        residuals = {balance.residual for balance in first.balances}
        variables = [one for one in found.differences if one.kind != "events" and one.name not in residuals]
        for done, one in enumerate(variables, start=1):
            drawn |= _draw_variable(logs, one)
            bar.update(done / (1 + len(variables)))
        files = [f"{name}: {log.path}, recorded {log.metadata.get('created')}" for name, log in zip(_NAMES, logs, strict=True)]
        lead = parts.paragraph(f"{found.message[0].upper()}{found.message[1:]}.")
        lead += parts.bullets([*files, *filter(None, [found.relation])], "dim")
        settings = [[name, *map(short_value, values)] for name, *values in found.settings]
        sections = {"First differences": _difference_table(found)}
        sections |= {"Settings that differ": parts.table(["setting", *_NAMES], settings)} if settings else {}
        title = f"Comparison: {' and '.join(log.path.name for log in logs)}"
        write_page(target, Page(title, lead, list((sections | figure_sections(drawn)).items())), drawn, file_format)
        bar.update(1.0)
    return found


def _difference_table(found: LogComparison) -> Markup:
    rows = []
    for one in found.differences:
        digits = 6 if f"{one.values[0]:.6g}" != f"{one.values[1]:.6g}" else 17
        values = [f"{value:.{digits}g}" for value in one.values]
        largest, index = "" if one.largest is None else f"{one.largest:.4g}", ", ".join(map(str, one.index))
        rows.append([one.name.replace("_", " "), typeset_unit(one.unit), one.time, index, *values, largest])
    differ = {one.name for one in found.differences}
    equal = ", ".join(name.replace("_", " ") for name in found.compared if name not in differ)
    words = parts.paragraph(f"Equal at all common times: {equal or 'none'}.")
    if found.not_compared:
        words += parts.paragraph(f"In one log only, or of different shapes: {', '.join(found.not_compared)}.")
    return (parts.table(["name", "unit", "time [s]", "element", *_NAMES, "largest difference"], rows) if rows else "") + words


def _draw_variable(logs: Logs, difference: Difference) -> dict[str, CaptionedFigure]:
    """Draw the histories of an input or an output in both logs and, along a row, the difference as x-t diagram."""
    name, title = difference.name, figure_title(difference.name)
    if curves := [curve for run, log in zip(_NAMES, logs, strict=True) for curve in _load_curves(log, difference, run)]:
        heading = "Inputs" if difference.kind == "input" else "Outputs"
        return {name: CaptionedFigure(heading, draw_curve_panels(curves), f"{title} over time.")}
    fields = [replace(one, run=run) for run, log in zip(_NAMES, logs, strict=True) for one in load_fields(log, name, FRAMES)]
    differences = _difference_fields(logs, name)
    figure = draw_fields(fields, "histories", None, default_indices(differences[0])[::2])
    drawn = {f"{name}-histories": CaptionedFigure(title, figure, f"{title} of elements at which the logs clearly differ.")}
    is_line = differences[0].coordinate is not None or not is_plane_filling(logs[0].drawables, differences[0].total)
    if is_line and len(differences) == 1 and differences[0].total > MOST_CURVES:
        words = f"{title} in B minus that in A: place (horizontal) and time (vertical)."
        drawn[f"{name}-difference"] = CaptionedFigure(title, draw_fields(differences, "space-time"), words)
    return drawn


def _load_curves(log: Any, difference: Difference, run: str) -> Iterator[Curve]:
    """Yield the curves of an input or a number, labelled with the name of the run; none for a recorded array."""
    acted = load_input_curves(log, difference.name) if difference.kind == "input" else None
    is_array = difference.kind == "input" or not curve_names(log.variables[difference.name])
    for one in acted.curves if acted is not None else () if is_array else load_curves(log, difference.name):
        yield replace(one, label=f"{run}: {one.label or one.name.replace('_', ' ')}")


def _difference_fields(logs: Logs, name: str) -> list[Field]:
    """Return an array of B minus that of A at common times, with one field for each component of a vector."""
    frames, fields = common_frames(logs, name), load_fields(logs[0], name, 2)
    most = max(2, min(FRAMES, MAXIMUM_POINTS // fields[0].values.shape[1]))
    picked = pick_evenly(len(frames[0]), most)
    (times, before), (_, after) = (sample_frames(log, name, own[picked]) for log, own in zip(logs, frames, strict=True))
    count, every = len(component_names(logs[0].variables[name])), fields[0].every
    values = (after - before).reshape(len(times), -1, count)[:, ::every]
    found = []
    for place, one in enumerate(fields):
        variable = replace(one.variable, name=f"{one.variable.name}, B - A")
        found.append(replace(one, variable=variable, times=times, values=values[:, :, place], cuts=one.cuts[:0]))
    return found


def _draw_bodies(logs: Logs, differences: list[Difference]) -> dict[str, CaptionedFigure]:
    """Draw the bodies of both logs, B to the right of A, at the same instants after the first difference."""
    scenes = [load_scene(log, 2) for log in logs]
    if not differences or not all(scene.is_plane for scene in scenes):
        return {}
    clocks = [shape.times for scene in scenes for shape in scene.shapes]
    start = max(differences[0].time, *(float(clock[0]) for clock in clocks))
    end = max(start, min(float(clock[-1]) for clock in clocks))
    times = np.linspace(start, end, _INSTANTS + 1)[1:].tolist()
    pairs = [[load_shapes(log, [time]) for log in logs] for time in times]
    everything = _join_scenes([scene for pair in pairs for scene in pair], np.zeros(3))
    if (scales := make_scales(everything)) is None:
        return {}
    plane = Plane(everything, scales)
    shift = (1.0 + _GAP) * float(np.ptp(plane.bounding_box, axis=0)[0]) * plane.eye_axes[:, 0]
    drawn = {}
    for number, pair in enumerate(pairs, start=1):
        figure = draw_plane(Plane(_join_scenes(pair, shift), scales))
        title = figure.axes[0].get_title("left")
        figure.axes[0].set_title(f"A (left) and B (right), {title}", loc="left", fontsize=11)
        words = f"A (left) and B (right). {plane_text(Plane(pair[0], scales))}" if number == len(pairs) else ""
        drawn[f"plane-{number}"] = CaptionedFigure("Pictures", figure, words)
    return drawn


def _join_scenes(scenes: Sequence[SceneData], shift: FloatArray) -> SceneData:
    """Return the shapes of all scenes, those of each scene shifted from those of the last one by a vector, shape (3,) [m]."""
    moved = [
        replace(
            scene,
            motions=tuple(replace(one, reference=one.reference + place * shift) for one in scene.motions),
            meshes=tuple(replace(one, nodes=one.nodes + place * shift) for one in scene.meshes),
        )
        for place, scene in enumerate(scenes)
    ]
    motions, meshes = ([one for scene in moved for one in getattr(scene, name)] for name in ("motions", "meshes"))
    return replace(scenes[0], motions=tuple(motions), meshes=tuple(meshes))
