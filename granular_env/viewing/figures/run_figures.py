"""Figures of a run: x-t diagrams, profiles, histories, balances, inputs.

Every function returns a matplotlib Figure created without pyplot: global state does not change and no window opens.
`drawing.to_png` converts a figure to the bytes of a file, `drawing.to_svg` to a part of a page.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

from granular_env.colours import PALETTE
from granular_env.components.errors import ParameterError

from ..curves import MOST_CURVES, Curve, load_input_curves
from ..recorded_fields import Field, array_names, load_curves, load_fields, nearest_frame, recorded_outputs
from ..scene_data import SceneData
from ..unit_labels import label_with_unit
from .drawing import (
    add_legend,
    draw_curves,
    draw_space_time,
    insert_gaps,
    line_style,
    mark_end_of_validity,
    marker_style,
    new_figure,
    place_name,
    time_unit,
    use_style,
)

# Number of frames read for a figure: more than for a viewer, because a figure is drawn only once.
FRAMES = 2000
# Kinds of array figures, and their heights [inch] (for profiles the height per time).
_HEIGHTS = {"space-time": 5.2, "profiles": 1.8, "histories": 4.2}
_PROFILES = 4
# Number of time intervals in which events are counted.
EVENT_BINS = 100
# The wave has reached a place if its value changes by more than this fraction of the largest change of all places.
_REACHED = 0.05


@use_style
def draw_fields(
    fields: Sequence[Field],
    kind: str,
    times: Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
    valid_until: float = np.inf,
) -> Figure:
    """Draw one field (values at many places over time), or several (such as the components of vectors) one above the other.

    Args:
        fields: the fields to draw.
        kind: "space-time" (x-t diagram), "profiles" (along the places at given times) or "histories" (of given places).
        times: times of the profiles [s]; default: four, evenly spaced.
        indices: places of the histories; default: up to five, evenly spaced among those that the wave reached.
        valid_until: end of validity [s], as in `SceneData`; histories mark it.

    Raises:
        ParameterError: a time outside the recorded span, or an unknown place.
    """
    count = (_PROFILES if times is None else len(times)) if kind == "profiles" else 1
    figure = new_figure(8.0, len(fields) * count * _HEIGHTS[kind])
    for part, shown in zip(figure.subfigures(len(fields), 1, squeeze=False).flat, fields, strict=True):
        if kind == "space-time":
            draw_space_time(part, part.subplots(), shown, None)
        elif kind == "profiles":
            _draw_profiles(part, shown, times)
        else:
            _draw_histories(part, shown, indices, valid_until)
    return figure


def _draw_profiles(figure: FigureBase, field: Field, times: Sequence[float] | None) -> None:
    first, last = float(field.times[0]), float(field.times[-1])
    scale, unit = time_unit(last)
    chosen = np.linspace(first, last, _PROFILES + 1)[1:].tolist() if times is None else list(times)
    panels = np.atleast_1d(figure.subplots(len(chosen), 1, sharex=True, sharey=True))
    for panel, time in zip(panels, chosen, strict=True):
        frame = nearest_frame(field.times, time)
        panel.plot(field.coordinates, field.values[frame], color=PALETTE[0], **marker_style(field))
        panel.set_title(f"t = {field.times[frame] * scale:.4g} {unit}", fontsize=11)
        panel.margins(x=0.01)
    figure.supylabel(field.label, fontsize=11)
    panels[-1].set_xlabel(field.axis)


def _draw_histories(figure: FigureBase, field: Field, indices: Sequence[int] | None, valid_until: float) -> None:
    scale, unit = time_unit(float(field.times[-1]))
    axes = figure.subplots()
    for place, index in enumerate(_default_indices(field) if indices is None else indices):
        column = _place_column(field, index)
        times, values = insert_gaps(field.times * scale, field.values[:, column], field.cuts)
        axes.plot(times, values, label=place_name(field, column), **line_style(place))
    axes.set(xlabel=f"time [{unit}]", ylabel=field.label)
    axes.margins(x=0.0)
    mark_end_of_validity(axes, valid_until * scale)
    add_legend(axes)


def _default_indices(field: Field) -> list[int]:
    """Return the numbers of up to five places, evenly spaced among those that the wave reached (all, if nothing changed)."""
    with np.errstate(invalid="ignore", over="ignore"):
        change = np.abs(field.values - field.values[0]).max(axis=0)
    largest = np.max(change, initial=0.0, where=np.isfinite(change))
    # Written as a negation, so that changes that are not finite are selected, too.
    reached = np.flatnonzero(~(change <= _REACHED * largest))
    reached = reached if len(reached) else np.arange(len(change))
    columns = reached[np.unique(np.rint(np.linspace(0, len(reached) - 1, 5)).astype(int))]
    return (columns * field.every).tolist()


def _place_column(field: Field, index: int) -> int:
    """Return the column of a field with the place number `index` (negative: from the end); `ParameterError` without it."""
    if not isinstance(index, int) or not -field.total <= index < field.total:
        raise ParameterError(
            f"got {index!r}", expected=f"a whole number from {-field.total} to {field.total - 1}", at="indices"
        )
    return (index % field.total) // field.every


@use_style
def draw_balance(scene_data: SceneData, quantity: str = "energy") -> Figure | None:
    """Draw the entries of a balance (such as the kinds of energy) over time, and below its residual; None without entries."""
    names = next((balance for balance in scene_data.balances if balance.quantity == quantity), None)
    if names is None or not (amounts := scene_data.named_curves(names.entries)):
        return None
    residuals = scene_data.named_curves(name for name in scene_data.curves if name.startswith(names.residual))
    words = quantity.replace("_", " ")
    figure = new_figure(8.0, 5.6 if residuals else 4.0)
    ratios = [3, 1] if residuals else [1]
    panels = np.atleast_1d(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
    draw_curves(panels[0], amounts, label_with_unit(words, names.unit), scene_data.valid_until)
    if residuals:
        panels[0].set_xlabel("")
        draw_curves(panels[1], residuals, label_with_unit("residual", names.unit))
    return figure


@use_style
def draw_curve_panels(chosen: Sequence[Curve], valid_until: float = np.inf) -> Figure:
    """Draw scalar curves (inputs, outputs), one panel for each unit."""
    units = list(dict.fromkeys(curve.unit for curve in chosen))
    figure = new_figure(8.0, 0.8 + 2.4 * len(units))
    panels = np.atleast_1d(figure.subplots(len(units), 1, sharex=True))
    for panel, unit in zip(panels, units, strict=True):
        panel_curves = [curve for curve in chosen if curve.unit == unit]
        name = panel_curves[0].name if len(panel_curves) == 1 else ""
        draw_curves(panel, panel_curves, label_with_unit(name, unit).strip(), valid_until)
        if panel is not panels[-1]:
            panel.set_xlabel("")
    return figure


@use_style
def draw_event_counts(events: Sequence[tuple[float, str]], span: tuple[float, float]) -> Figure:
    """Draw the number of events in each interval of the run.

    Args:
        events: time [s] and kind of each event.
        span: start and end of the run [s].
    """
    scale, unit = time_unit(span[1])
    figure = new_figure(8.0, 2.6)
    axes = figure.subplots()
    edges = np.linspace(span[0], span[1] if span[1] > span[0] else span[0] + 1.0, EVENT_BINS + 1)
    below = np.zeros(EVENT_BINS)
    for place, kind in enumerate(dict.fromkeys(kind for _, kind in events)):
        counts, _ = np.histogram([time for time, one in events if one == kind], edges)
        axes.bar(
            scale * edges[:-1], counts, scale * np.diff(edges), below, align="edge", color=PALETTE[place % len(PALETTE)],
            label=kind.replace("_", " "),
        )  # fmt: skip
        below += counts
    axes.set(xlabel=f"time [{unit}]", ylabel="events", xlim=(scale * edges[0], scale * edges[-1]))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    add_legend(axes)
    return figure


def plot(
    log: Any,
    variable: str,
    kind: str = "space-time",
    *,
    times: Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
) -> Figure:
    """Return a figure of a recorded variable or an input of a log.

        figure = ge.viewing.plot(log, "contact_force", "histories", indices=[10, 20])
        figure.savefig("force.pdf")              # a notebook displays it after %matplotlib inline

    Args:
        log: an open log.
        variable: a recorded output, or an input. Scalars and inputs of a few numbers are drawn as curves over time for every
            kind; the components of vectors are drawn one above the other.
        kind: figure of an array: "space-time", "profiles" (at `times`) or "histories" (of `indices`).
        times: times of the profiles [s]; default: four, evenly spaced.
        indices: elements of the histories; default: up to five that changed.

    Returns:
        A figure outside pyplot; its axes (`figure.axes`) may be changed.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: the log does not contain the variable, a time or an index, or the kind is unknown.
    """
    if kind not in _HEIGHTS:
        raise ParameterError(f"got {kind!r}", expected=f"one of {', '.join(_HEIGHTS)}", at="kind")
    if variable in array_names(log):
        return draw_fields(load_fields(log, variable, FRAMES), kind, times, indices)
    if variable in (recorded := recorded_outputs(log)):
        return draw_curve_panels(list(load_curves(log, variable)))
    if variable in log.input_variables and (acted := load_input_curves(log, variable)) is not None:
        if prod(acted.variable.shape) <= MOST_CURVES:
            return draw_curve_panels(acted.curves)
        fields = load_fields(log, variable, FRAMES)
        return draw_fields([one for one in fields if one.values.any()] or fields[:1], kind, times, indices)
    known = ", ".join([*recorded, *log.input_variables])
    raise ParameterError(f"{variable!r} was not recorded", hint=f"this log contains {known}", at="variable")
