"""Figures of a run: x-t diagrams, profiles, histories, balances, inputs.

Every function returns a matplotlib Figure created without pyplot: global state does not change and no window opens.
`drawing.to_png` converts a figure to the bytes of a file, `drawing.to_svg` to a part of a page.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

from granular_env.colours import PALETTE
from granular_env.components.errors import ParameterError

from ..curves import Curve
from ..recorded_fields import Field, nearest_frame
from ..scene_data import SceneData
from .drawing import (
    add_legend,
    draw_curves,
    draw_space_time,
    line_style,
    new_figure,
    time_unit,
    use_style,
    value_scale,
)

# Number of frames read for a figure: more than for a viewer, because a figure is drawn only once.
FRAMES = 2000
# Kinds of array figures, and their heights [inch] (for profiles the height per time).
_HEIGHTS = {"space-time": 5.2, "profiles": 1.8, "histories": 4.2}
# Number of profiles by default, and largest number of places that a profile marks with dots.
_PROFILES, _MOST_MARKERS = 4, 60
# Number of time intervals in which events are counted.
_EVENT_BINS = 100
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
    """Draw fields (values at many places over time), each quantity (such as a component of vectors) below the last one.

    Args:
        fields: the fields to draw; profiles and histories of one quantity, from several runs, share their axes.
        kind: "space-time" (x-t diagram), "profiles" (along the places at given times) or "histories" (of given places).
        times: times of the profiles [s]; default: four, evenly spaced.
        indices: places of the histories; default: up to five, evenly spaced among those that the wave reached.
        valid_until: end of validity [s], as in `SceneData`; histories mark it.

    Raises:
        ParameterError: a time outside the recorded span, or an unknown place.
    """
    count = (_PROFILES if times is None else len(times)) if kind == "profiles" else 1
    quantities = list(dict.fromkeys(field.variable.name for field in fields))
    figure = new_figure(8.0, len(quantities) * count * _HEIGHTS[kind])
    for part, quantity in zip(figure.subfigures(len(quantities), 1, squeeze=False).flat, quantities, strict=True):
        shown = [field for field in fields if field.variable.name == quantity]
        if kind == "space-time":
            draw_space_time(part, part.subplots(), shown[0], None)
        elif kind == "profiles":
            _draw_profiles(part, shown, times)
        else:
            _draw_histories(part, shown, indices, valid_until)
    return figure


def _draw_profiles(figure: FigureBase, fields: Sequence[Field], times: Sequence[float] | None) -> None:
    first, last = max(float(field.times[0]) for field in fields), min(float(field.times[-1]) for field in fields)
    scale, unit = time_unit(last)
    chosen = np.linspace(first, last, _PROFILES + 1)[1:].tolist() if times is None else list(times)
    frames = [[nearest_frame(field.times, time) for time in chosen] for field in fields]
    values = [field.values[own] for field, own in zip(fields, frames, strict=True)]
    factor, label = value_scale(fields[0].variable.name, fields[0].variable.unit, *values)
    across, axis = fields[0].place_axis
    panels = np.atleast_1d(figure.subplots(len(chosen), 1, sharex=True, sharey=True))
    for place, panel in enumerate(panels):
        for number, (field, own) in enumerate(zip(fields, values, strict=True)):
            marker = "o" if field.values.shape[1] <= _MOST_MARKERS else ""
            style = {**line_style(number), "marker": marker, "markersize": 3}
            panel.plot(across * field.coordinates, factor * own[place], label=field.run, **style)
        panel.set_title(f"t = {fields[0].times[frames[0][place]] * scale:.4g} {unit}", fontsize=11)
        panel.margins(x=0.01)
    if len(fields) > 1:
        add_legend(panels[0])
    figure.supylabel(label, fontsize=11)
    panels[-1].set_xlabel(axis)
    if fields[0].coordinate is None:
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))


def _draw_histories(figure: FigureBase, fields: Sequence[Field], indices: Sequence[int] | None, valid_until: float) -> None:
    chosen = default_indices(fields[0]) if indices is None else indices
    curves = [field.history(find_place(field, index)) for index in chosen for field in fields]
    runs = len(fields) if len(chosen) > 1 else 1
    draw_curves(figure.subplots(), curves, fields[0].variable.name, valid_until, runs)


def default_indices(field: Field) -> list[int]:
    """Return the numbers of up to five places, evenly spaced among those that the wave reached (all, if nothing changed)."""
    with np.errstate(invalid="ignore", over="ignore"):
        change = np.abs(field.values - field.values[0]).max(axis=0)
    largest = np.max(change, initial=0.0, where=np.isfinite(change))
    # Written as a negation, so that changes that are not finite are selected, too.
    reached = np.flatnonzero(~(change <= _REACHED * largest))
    reached = reached if len(reached) else np.arange(len(change))
    columns = reached[np.unique(np.rint(np.linspace(0, len(reached) - 1, 5)).astype(int))]
    return (columns * field.every).tolist()


def find_place(field: Field, index: int) -> int:
    """Return the number of the place with an index, which may count from the end; `ParameterError` if there is none."""
    if not isinstance(index, int | np.integer) or not -field.total <= index < field.total:
        raise ParameterError(
            f"got {index!r}", expected=f"a whole number from {-field.total} to {field.total - 1}", at="indices"
        )
    return index % field.total


@use_style
def draw_balance(scene_data: SceneData, quantity: str = "energy") -> Figure | None:
    """Draw the entries of a balance (such as the kinds of energy) over time, and below its residual; None without entries."""
    names = next((balance for balance in scene_data.balances if balance.quantity == quantity), None)
    if names is None or not (amounts := scene_data.named_curves(names.entries)):
        return None
    residuals = scene_data.named_curves(name for name in scene_data.curves if name.startswith(names.residual))
    words = quantity.replace("_", " ")
    figure = new_figure(8.0, 5.6 if residuals else 4.0)
    ratios = [2, 1] if residuals else [1]
    panels = np.atleast_1d(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
    draw_curves(panels[0], amounts, words, scene_data.valid_until)
    if residuals:
        panels[0].set_xlabel("")
        draw_curves(panels[1], residuals, "residual")
    return figure


@use_style
def draw_curve_panels(chosen: Sequence[Curve], valid_until: float = np.inf) -> Figure:
    """Draw scalar curves (inputs, outputs), one panel for each unit."""
    units = list(dict.fromkeys(curve.unit for curve in chosen))
    figure = new_figure(8.0, 0.8 + 2.4 * len(units))
    panels = np.atleast_1d(figure.subplots(len(units), 1, sharex=True))
    for panel, unit in zip(panels, units, strict=True):
        panel_curves = [curve for curve in chosen if curve.unit == unit]
        # The name of the variable without direction and place, if all curves show one variable.
        names = {re.sub(r"(_[xyz])?(\[.*)?$", "", curve.name) for curve in panel_curves}
        draw_curves(panel, panel_curves, names.pop() if len(names) == 1 else "", valid_until)
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
    start, end = scale * span[0], scale * span[1] if span[1] > span[0] else scale * span[0] + 1.0
    kinds = list(dict.fromkeys(kind for _, kind in events))
    times = [[scale * time for time, one in events if one == kind] for kind in kinds]
    style = {"color": np.resize(PALETTE, len(kinds)).tolist(), "label": [kind.replace("_", " ") for kind in kinds]}
    axes.hist(times, bins=_EVENT_BINS, range=(start, end), stacked=True, **style)
    axes.set(xlabel=f"time [{unit}]", ylabel="events", xlim=(start, end))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    add_legend(axes)
    return figure
