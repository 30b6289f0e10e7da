"""The page for two logs: their first differences, the settings that differ, and figures that show both logs."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from granular_env.progress import Progress, progress_bar
from granular_env.recording.comparison import Difference, LogComparison, Logs, compare_logs

from ..curves import Curve, component_names, load_input_curves
from ..figures.drawing import use_style
from ..figures.plane import Plane, draw_instant, instant_text, make_panels, plane_text
from ..figures.run_figures import FRAMES, draw_curve_panels, draw_fields
from ..html_page import Page, parts
from ..recorded_fields import curve_names, load_curves, load_fields
from ..scene_builder import load_scene, load_shapes, require_log
from ..scene_scales import make_scales
from ..unit_labels import typeset_unit
from .figures import CaptionedFigure, figure_title
from .page import figure_sections, require_page, write_page
from .tables import short_value

_NAMES = ("A", "B")
_INSTANTS = 3


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
        drawn = _draw_bodies(logs, found.differences[0].time) if found.differences else {}
        residuals = {balance.residual for balance in first.balances}
        variables = [one for one in found.differences if one.kind != "events" and one.name not in residuals]
        for done, one in enumerate(variables, start=1):
            drawn[one.name] = _draw_variable(logs, one)
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
        # All digits of values that agree in the first six.
        texts = [f"{value:.6g}" for value in one.values]
        values = one.values if texts[0] != texts[1] else map(repr, one.values)
        index, largest = ", ".join(map(str, one.index)), "" if one.largest is None else one.largest
        rows.append([one.name.replace("_", " "), typeset_unit(one.unit), one.time, index, *values, largest])
    differ = {one.name for one in found.differences}
    equal = ", ".join(name.replace("_", " ") for name in found.compared if name not in differ)
    words = parts.paragraph(f"Equal at all common times: {equal or 'none'}.")
    words += parts.paragraph(
        "Figures of output arrays show the elements with the first and with the largest difference.", "dim"
    )
    words += parts.paragraph(found.omission) if found.omission else ""
    return (parts.table(["name", "unit", "time [s]", "element", *_NAMES, "largest difference"], rows) if rows else "") + words


def _draw_variable(logs: Logs, difference: Difference) -> CaptionedFigure:
    """Draw an input or an output of both logs over time; of an array, the elements with the first and largest difference."""
    name, runs, curves = difference.name, list(zip(_NAMES, logs, strict=True)), list[Curve]()
    variable = {**logs[0].variables, **logs[0].input_variables}[name]
    words = f"{variable.description[0].upper()}{variable.description[1:]}."
    for run, log in runs:
        acted = load_input_curves(log, name) if difference.kind == "input" else None
        own = acted.curves if acted is not None else load_curves(log, name) if curve_names(variable) else ()
        curves += [replace(one, label=f"{run}: {one.label or one.name.replace('_', ' ')}") for one in own]
    if curves:
        return CaptionedFigure("Inputs" if difference.kind == "input" else "Outputs", draw_curve_panels(curves), words)
    indices, components = (difference.index, difference.largest_index), len(component_names(variable))
    places = dict.fromkeys(int(np.ravel_multi_index(index, variable.shape)) // components for index in indices)
    fields = [replace(one, run=run) for run, log in runs for one in load_fields(log, name, FRAMES)]
    return CaptionedFigure(figure_title(name), draw_fields(fields, "histories", indices=list(places)), words)


@use_style
def _draw_bodies(logs: Logs, start: float) -> dict[str, CaptionedFigure]:
    """Draw the bodies of A (left) and B (right) at the same instants after the time `start` [s], with one scale."""
    scenes = [load_scene(log, 2) for log in logs]
    clocks = [shape.times for scene in scenes for shape in scene.shapes]
    if not clocks or not all(scene.is_plane for scene in scenes):
        return {}
    first, last = max(start, *(float(clock[0]) for clock in clocks)), min(float(clock[-1]) for clock in clocks)
    times = np.linspace(first, max(first, last), _INSTANTS + 1)[1:].tolist()
    shown = [load_shapes(log, [time]) for time in times for log in logs]
    motions, meshes = (tuple(shape for scene in shown for shape in getattr(scene, kind)) for kind in ("motions", "meshes"))
    everything = replace(shown[0], motions=motions, meshes=meshes)
    scales = make_scales(everything)
    assert scales is not None
    plane = Plane(everything, scales)
    (low, high), (figure, panels) = plane.bounding_box, make_panels(plane, _INSTANTS, len(_NAMES))
    for axes, scene, run in zip(panels, shown, _NAMES * _INSTANTS, strict=True):
        own = Plane(replace(scene, focus_normal=everything.focus_normal), scales)
        draw_instant(axes, own, 0)
        axes.set_title(f"{run}, t = {instant_text(own, 0)}", fontsize=11)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    words = f"A (left) and B (right). {plane_text(Plane(shown[-1], scales))}"
    return {"pictures": CaptionedFigure("Pictures", figure, words)}
