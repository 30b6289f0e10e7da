"""Figures of a run: x-t diagram, profiles, histories, balances, inputs.

Every function takes a `Field`, or a `Motion` for the quantity that colours it, or curves, and returns a matplotlib Figure made
without pyplot, so nothing global changes and no window opens. Colours are those of the viewer and can be told apart by the
colour-blind. `drawing.png` turns a figure into a file's bytes, `drawing.svg` into a part of a page.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from granular_env.colours import DIVERGING, PALETTE
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.optional_packages import import_optional

from ..curves import Curve
from ..recorded_fields import Field, as_field
from ..scene_data import Motion, SceneData
from ..unit_labels import label_with_unit
from .drawing import (
    draw_curves,
    draw_space_time,
    insert_gaps,
    legend,
    line,
    mark_end_of_validity,
    markers,
    name_of_place,
    new_figure,
    place_axis,
    quantity,
    span,
    time_unit,
    with_style,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Frames that figures use: more than a viewer, they are only drawn once.
FRAMES = 2000
# Where a legend stands beside a second axis, from the axes [inch]. In widths of the axes, which the layout makes narrower for
# the legend, it would end outside of the figure.
_BEYOND_AXIS = 0.95
# Parts of a run in which events are counted.
EVENT_BINS = 100
# The wave has reached a particle that changed by this part of the largest change.
_REACHED = 0.05


@with_style
def space_time(motion: Motion | Field, title: str = "", limit: float | None = None, into: Figure | None = None) -> Figure:
    """Draw the x-t diagram; `limit`: the value at the ends of the colour map (default: the largest magnitude)."""
    shown = as_field(motion)
    figure = into or new_figure(8.0, 5.2)
    axes = figure.subplots()
    draw_space_time(figure, axes, shown, limit)
    axes.set_title(title)
    return figure


@with_style
def stack(fields: Sequence[Field], draw: Callable[[Field, Figure], object], height: float = 4.0) -> Figure:
    """Draw one figure for each field, such as the components of vectors, one above the other, each so high [inch]."""
    figure = new_figure(8.0, height * len(fields))
    for part, shown in zip(figure.subfigures(len(fields), 1, squeeze=False).flat, fields, strict=True):
        draw(shown, part)
    return figure


@with_style
def headline(motion: Motion | Field, title: str = "") -> Figure:
    """Draw the x-t diagram, with the profile at the last instant above it."""
    shown = as_field(motion)
    figure = new_figure(8.6, 6.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 5])
    draw_space_time(figure, below, shown, None)
    values, scale_unit = shown.values[-1], time_unit(span(shown))
    above.fill_between(shown.across, values, color=DIVERGING[-1], alpha=0.2, linewidth=0.0)
    above.plot(shown.across, values, color=DIVERGING[-1], linewidth=1.2, **markers(shown))
    above.set_ylabel(quantity(shown))
    above.text(0.01, 0.95, f"at {span(shown) * scale_unit[0]:.4g} {scale_unit[1]}", transform=above.transAxes, va="top")
    above.set_title(title)
    return figure


@with_style
def profiles(motion: Motion | Field, times: Sequence[float] | None = None, into: Figure | None = None) -> Figure:
    """Draw the quantity along the places at some instants [s] (default: four, evenly spaced).

    Raises:
        ParameterError: an instant outside the recorded span.
    """
    shown = as_field(motion)
    scale, unit = time_unit(span(shown))
    chosen = default_times(shown) if times is None else list(times)
    figure = into or new_figure(8.0, 0.8 + 1.6 * len(chosen))
    panels = np.atleast_1d(figure.subplots(len(chosen), 1, sharex=True, sharey=True))
    for panel, time in zip(panels, chosen, strict=True):
        frame = frame_at(shown.times, time)
        panel.plot(shown.across, shown.values[frame], color=PALETTE[0], **markers(shown))
        panel.set_title(f"t = {shown.times[frame] * scale:.4g} {unit}", fontsize=11)
        panel.margins(x=0.01)
    figure.supylabel(quantity(shown), fontsize=11)
    panels[-1].set_xlabel(place_axis(shown))
    return figure


@with_style
def histories(
    motion: Motion | Field,
    indices: Sequence[int] | None = None,
    into: Figure | None = None,
    valid_until: float = np.inf,
) -> Figure:
    """Draw the quantity of some places in time (default: up to five that the wave reached).

    Raises:
        ParameterError: no such place.
    """
    shown = as_field(motion)
    scale, unit = time_unit(span(shown))
    chosen = default_indices(shown) if indices is None else list(indices)
    columns = [column_of(shown, index) for index in chosen]
    figure = into or new_figure(8.0, 4.2)
    axes = figure.subplots()
    for place, column in enumerate(columns):
        times, values = insert_gaps(shown.times * scale, shown.values[:, column], shown.cuts)
        axes.plot(times, values, label=name_of_place(shown, column), **line(place))
    axes.set(xlabel=f"time [{unit}]", ylabel=quantity(shown))
    axes.margins(x=0.0)
    mark_end_of_validity(axes, valid_until * scale)
    legend(axes)
    return figure


@with_style
def balance(scene_data: SceneData, quantity: str = "energy") -> Figure | None:
    """Draw the entries of a balance in time, and below them its residual; None where there are none."""
    names = next((balance for balance in scene_data.balances if balance.quantity == quantity), None)
    if names is None or not (amounts := scene_data.group(names.entries)):
        return None
    residuals = [
        # The axis says that they are residuals: of a vector the legend names the direction alone.
        replace(curve, name=curve.name.removeprefix(f"{names.residual}_"))
        for curve in scene_data.group(name for name in scene_data.curves if name.startswith(names.residual))
    ]
    words = quantity.replace("_", " ")
    figure = new_figure(8.0, 5.6 if residuals else 4.0)
    ratios = [3, 1] if residuals else [1]
    panels = np.atleast_1d(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
    draw_curves(panels[0], amounts, label_with_unit(words, names.unit), scene_data.valid_until)
    if residuals:
        panels[0].set_xlabel("")
        draw_curves(panels[1], residuals, label_with_unit("residual", names.unit))
        largest = max(float(np.nanmax(np.abs(curve.values))) for curve in amounts)
        relative = panels[1].secondary_yaxis("right", functions=(lambda amount: amount / largest, lambda part: part * largest))
        relative.set_ylabel(f"of the largest\n{words}")
        relative.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
        if (names_of_residuals := panels[1].get_legend()) is not None:
            transforms = import_optional("matplotlib.transforms", "figures")
            beyond = transforms.ScaledTranslation(_BEYOND_AXIS, 0.0, figure.dpi_scale_trans)
            names_of_residuals.set_bbox_to_anchor((1.0, 1.0), panels[1].transAxes + beyond)
    return figure


@with_style
def curves(chosen: Sequence[Curve], valid_until: float = np.inf) -> Figure:
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


@with_style
def event_counts(events: Sequence[tuple[float, str]], span: tuple[float, float]) -> Figure:
    """Draw how many events there were when.

    Args:
        events: the instant [s] and the kind of each.
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
    axes.yaxis.set_major_locator(import_optional("matplotlib.ticker", "figures").MaxNLocator(integer=True))
    legend(axes)
    return figure


# -- choices --------------------------------------------------------------------------------------------------------------


def default_times(motion: Motion | Field) -> list[float]:
    """Four instants, evenly spaced, the last one the end [s]."""
    first, last = float(motion.times[0]), float(motion.times[-1])
    return [first + (last - first) * part for part in (0.25, 0.5, 0.75, 1.0)]


def default_indices(motion: Motion | Field) -> list[int]:
    """Up to five places, evenly spaced among those that the wave reached (all of them, where nothing changed)."""
    shown = as_field(motion)
    with np.errstate(invalid="ignore", over="ignore"):
        change = np.abs(shown.values - shown.values[0]).max(axis=0)
    largest = np.max(change, initial=0.0, where=np.isfinite(change))
    # What is not finite has changed too.
    reached = np.flatnonzero(~(change <= _REACHED * largest))
    if not len(reached):
        reached = np.arange(len(change))
    columns = reached[np.unique(np.rint(np.linspace(0, len(reached) - 1, 5)).astype(int))]
    return (columns * shown.every).tolist()


def frame_at(times: FloatArray, time: float) -> int:
    """Return which frame is nearest to an instant [s]; `ParameterError` outside the recorded span."""
    first, last = float(times[0]), float(times[-1])
    slack = 1e-9 * max(abs(first), abs(last))
    if isinstance(time, bool) or not isinstance(time, (int, float)) or not first - slack <= time <= last + slack:
        got = f"{time:g} s" if isinstance(time, (int, float)) else repr(time)
        raise ParameterError(f"got {got}", expected=f"{first:g} to {last:g} s, the recorded span", at="times")
    return int(np.argmin(np.abs(times - time)))


def column_of(shown: Motion | Field, index: int) -> int:
    """Return the column of a place (negative numbers count from the end); `ParameterError` where there is none."""
    if not isinstance(index, int) or not -shown.total <= index < shown.total:
        raise ParameterError(
            f"got {index!r}", expected=f"a whole number from {-shown.total} to {shown.total - 1}", at="indices"
        )
    return (index % shown.total) // shown.every
