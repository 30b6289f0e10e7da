"""The bar of a scale of colours, with its numbers, in a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from granular_env.colours import DIVERGING
from granular_env.optional_packages import import_optional

from ..scene_scales import ColourScale

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Limits of a scale between which its numbers are written as they are; others with the prefixes of units, such as 400 M.
_PLAIN = 1e-3, 1e4
# Steps of the numbers at most: more of them, as long as "-100 M", would run together in a bar as wide as half a page.
_MOST_STEPS = 6


def add_bar(figure: Figure, scale: ColourScale, **where: Any) -> None:
    """Draw the bar of a scale.

    Args:
        figure: where to.
        scale: what the colours mean.
        where: the axes to draw in (cax) or beside (ax), and other options of matplotlib's `Figure.colorbar`.
    """
    colors = import_optional("matplotlib.colors", "figures")
    anchors, low = DIVERGING, -scale.limit
    if not scale.has_sign:
        # The blue half would say nothing.
        anchors, low = DIVERGING[len(DIVERGING) // 2 :], 0.0
    shades = import_optional("matplotlib.cm", "figures").ScalarMappable(
        colors.Normalize(low, scale.limit), colors.LinearSegmentedColormap.from_list("granular", anchors)
    )
    beyond = "both" if scale.has_sign else "max"
    extend = beyond if scale.is_exceeded else "neither"
    ticker = import_optional("matplotlib.ticker", "figures")
    if not _PLAIN[0] <= scale.limit <= _PLAIN[1]:
        where["format"] = ticker.EngFormatter()
    where["ticks"] = ticker.MaxNLocator(_MOST_STEPS, steps=[1, 2, 2.5, 5, 10])
    figure.colorbar(shades, orientation="horizontal", label=scale.label, extend=extend, **where)
