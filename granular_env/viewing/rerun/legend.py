"""The legend of a scene: a bar with numbers for each scale of colours, as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from granular_env.optional_packages import import_optional

from ..colour_scales import ColourScale
from ..figures.colour_bar import add_bar
from ..figures.drawing import DARK, canvas, new_figure

LEGEND = "legend"
# Of one bar with its numbers [inch], and its pixels.
WIDTH, HEIGHT = 5.0, 0.8
_DOTS_PER_INCH = 150


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
