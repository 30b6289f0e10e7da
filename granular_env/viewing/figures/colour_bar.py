"""The labelled colour bar of a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

from granular_env.colours import DIVERGING, ColourScale

from ..unit_labels import scaled_label
from .drawing import new_figure

# Largest number of intervals between labels; with more, the labels of a bar half a page wide would overlap.
_MOST_STEPS = 6


def add_colour_bar(figure: FigureBase, scale: ColourScale, **where: Any) -> None:
    """Draw the bar of a colour scale; if no value is negative, the blue half is omitted.

    Args:
        figure: the figure to draw in.
        scale: the colour scale.
        where: the axes to draw in (cax) or next to (ax), and other options of `Figure.colorbar`.
    """
    factor, label = scaled_label(", ".join(scale.names), scale.unit, scale.limit)
    label += ": all 0" if scale.is_zero else ""
    anchors, low = (DIVERGING, -scale.limit) if scale.has_sign else (DIVERGING[len(DIVERGING) // 2 :], 0.0)
    shades = ScalarMappable(
        Normalize(factor * low, factor * scale.limit), LinearSegmentedColormap.from_list("granular", anchors)
    )
    beyond = "both" if scale.has_sign else "max"
    figure.colorbar(
        shades, orientation="horizontal", label=label, extend=beyond if scale.is_exceeded else "neither",
        ticks=MaxNLocator(_MOST_STEPS, steps=[1, 2, 2.5, 5, 10]), **where,
    )  # fmt: skip


def draw_colour_bars(scales: Sequence[ColourScale], width: float, height: float) -> Figure:
    """Draw the bars of several scales below each other, each of the given width and height [inch]."""
    figure = new_figure(width, height * len(scales))
    fill_with_colour_bars(figure, scales)
    return figure


def fill_with_colour_bars(figure: FigureBase, scales: Sequence[ColourScale]) -> None:
    """Draw the bars of several scales below each other into an empty figure."""
    for axes, scale in zip(figure.subplots(len(scales), 1, squeeze=False)[:, 0], scales, strict=True):
        add_colour_bar(figure, scale, cax=axes)
