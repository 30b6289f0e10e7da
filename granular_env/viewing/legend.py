"""The legend of a scene: a bar with numbers for each scale of colours, as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.colours import DIVERGING

from ..optional_packages import import_optional
from .colour_scales import ColourScale
from .figures.style import DARK, canvas, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEGEND = "legend"
# Of one bar with its numbers [inch], and its pixels.
WIDTH, HEIGHT = 5.0, 0.8
_DOTS_PER_INCH = 150


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
    figure.colorbar(shades, orientation="horizontal", label=scale.label, extend=extend, **where)


def send_legend(recording: Any, scales: Sequence[ColourScale]) -> None:
    """Send the picture of all scales, in the place of one that was sent before."""
    if not scales:
        return
    rr = import_optional("rerun", "the viewer")
    with import_optional("matplotlib", "figures").rc_context(DARK):
        figure = new_figure(WIDTH, HEIGHT * len(scales))
        panels = figure.subplots(len(scales), 1, squeeze=False)[:, 0]
        for axes, scale in zip(panels, scales, strict=True):
            add_bar(figure, scale, cax=axes)
        pixels = canvas(figure, _DOTS_PER_INCH).buffer_rgba()
    recording.log(LEGEND, rr.Image(np.asarray(pixels)[..., :3]), static=True)
