"""The bar of a scale of colours, with its numbers, in a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from granular_env.colours import DIVERGING

from ..scene_scales import ColourScale
from .drawing import new_figure

# Numbers between these limits are written in full; others with the prefixes of units, such as 400 M.
_PLAIN = 1e-3, 1e4
# Most steps of the numbers: more would overlap in a bar as wide as half a page.
_MOST_STEPS = 6


def add_bar(figure: Figure, scale: ColourScale, **where: Any) -> None:
    """Draw the bar of a scale; one without negative values has no blue half.

    Args:
        figure: where to.
        scale: what the colours mean.
        where: the axes to draw in (cax) or next to (ax), and other options of matplotlib's `Figure.colorbar`.
    """
    anchors, low = (DIVERGING, -scale.limit) if scale.has_sign else (DIVERGING[len(DIVERGING) // 2 :], 0.0)
    shades = ScalarMappable(Normalize(low, scale.limit), LinearSegmentedColormap.from_list("granular", anchors))
    beyond = "both" if scale.has_sign else "max"
    if not _PLAIN[0] <= scale.limit <= _PLAIN[1]:
        where["format"] = EngFormatter()
    figure.colorbar(
        shades, orientation="horizontal", label=scale.label, extend=beyond if scale.is_exceeded else "neither",
        ticks=MaxNLocator(_MOST_STEPS, steps=[1, 2, 2.5, 5, 10]), **where,
    )  # fmt: skip


def draw_bars(scales: Sequence[ColourScale], width: float, height: float) -> Figure:
    """Draw the bars of some scales below each other, each so wide and high [inch]."""
    figure = new_figure(width, height * len(scales))
    for axes, scale in zip(figure.subplots(len(scales), 1, squeeze=False)[:, 0], scales, strict=True):
        add_bar(figure, scale, cax=axes)
    return figure
