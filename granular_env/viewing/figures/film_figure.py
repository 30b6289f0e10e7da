"""The figure of a film: its frames are drawn one after another with the same layout, size and scales."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from granular_env.colours import PALETTE
from granular_env.components.support.float_arrays import FloatArray

from ..scene_data import ProfileFrames
from ..unit_labels import scaled_label
from .drawing import new_figure, render_canvas, use_style
from .keys import draw_keys, keys_height
from .plane import Plane, draw_instant, instant_text

# Largest size of the picture of the body, its least width and height, its margins, height of a profile and of the title [inch].
_LARGEST, _NARROWEST, _LOWEST, _MARGIN, _PROFILE, _TITLE = (7.2, 5.4), 4.6, 0.1, 0.15, 1.5, 0.35
_MOST_PROFILES = 3
# Transparent background on an HTML page, and grey of the keys, visible on light and dark pages.
_PAGE_STYLE: Any = {"text.color": "#808890", "figure.facecolor": "none", "axes.facecolor": "none"}


class FilmFigure:
    """A figure with the picture of the bodies, curves along x if there are any, and the keys.

    Args:
        plane: the bodies in all frames of the film.
        is_page: whether an HTML page, which prints title, time and colour bars itself, shows the pictures.
        dots_per_inch: resolution, for the natural size.
        size: width and height in pixels; None for the natural size, which fits the bodies.
    """

    @use_style
    def __init__(self, plane: Plane, dots_per_inch: float, size: tuple[int, int] | None = None, is_page: bool = False) -> None:
        self._plane, self._profiles = plane, [] if is_page else _profiles_to_show(plane)
        low, high = plane.bounding_box
        across, up = (high - low).tolist()
        scale = min(_LARGEST[0] / across, _LARGEST[1] / up)
        width = max(scale * across, _LARGEST[0] if self._profiles else _NARROWEST)
        body, below = max(scale * up, _LOWEST) + _MARGIN, keys_height(plane, bars=not is_page)
        above = (0.0 if is_page else _TITLE) + body + _PROFILE * len(self._profiles)
        inches = width, above + below
        if size is not None:
            dots_per_inch = min(size[0] / inches[0], size[1] / inches[1])
        # Codecs need even numbers of pixels.
        drawn = [2 * round(0.5 * dots_per_inch * length) for length in inches]
        self._dots_per_inch, margins = dots_per_inch, np.subtract(size or drawn, drawn)[::-1]
        self._margins = [(one // 2, one - one // 2) for one in margins.tolist()]
        with matplotlib.rc_context(_PAGE_STYLE if is_page else {}):
            # The small addend keeps rounding errors from taking off a pixel.
            self._figure = new_figure(*((pixels + 1e-3) / dots_per_inch for pixels in drawn))
            upper, keys = self._figure.subfigures(2, 1, squeeze=False, height_ratios=[above, below]).flat
            ratios = [body, *(_PROFILE for _ in self._profiles)]
            self._axes, *panels = upper.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False)[:, 0]
            draw_keys(keys, self._axes, plane, bars=not is_page)
        self._curves = [_draw_profile(axes, one, plane) for axes, one in zip(panels, self._profiles, strict=True)]
        for axes in panels[:-1]:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
        self._heading = upper.suptitle(" ", x=0.01, horizontalalignment="left", fontsize=11) if not is_page else None
        self.draw_frame(0)
        self._figure.set_layout_engine("none")

    @use_style
    def draw_frame(self, frame: int) -> npt.NDArray[np.uint8]:
        """Return the picture of a frame of `plane` as pixels, shape (height, width, 4)."""
        for drawn in list(self._axes.collections):
            drawn.remove()
        draw_instant(self._axes, self._plane, frame)
        if self._heading is not None:
            self._heading.set_text(f"{self._plane.scene.title}      t = {instant_text(self._plane, frame)}")
        for (line, values), profile in zip(self._curves, self._profiles, strict=True):
            line.set_ydata(values[np.abs(profile.times - self._plane.times[frame]).argmin()])
        pixels = np.asarray(render_canvas(self._figure, self._dots_per_inch).buffer_rgba())
        return np.pad(pixels, [*self._margins, (0, 0)], constant_values=255)


def _profiles_to_show(plane: Plane) -> list[ProfileFrames]:
    """Return the fields along x: those of the component, or the values that colour a row of particles."""
    rows = [
        ProfileFrames(one.name, one.times, one.ticks, one.reference[:, 0], one.colour, one.colour_variable)
        for one in plane.scene.motions
        if not one.is_plane and one.colour is not None
    ]
    return [*plane.scene.profiles, *rows][:_MOST_PROFILES]


def _draw_profile(axes: Axes, profile: ProfileFrames, plane: Plane) -> tuple[Line2D, FloatArray]:
    """Draw the first frame with the limits of all frames; return the curve, and its values in the unit of the axis."""
    factor, label = scaled_label(profile.variable.name, profile.variable.unit, float(np.abs(profile.values).max(initial=0.0)))
    # Align the curve with the picture, except a body in space, whose picture is not along x.
    across = profile.coordinate[[0, -1]] if plane.scene.is_solid else np.array(plane.bounding_box)[:, 0]
    words = "x" if any(profile is one for one in plane.scene.profiles) else "initial x"
    length, name = scaled_label(words, "m", float(np.abs(across).max()))
    [line] = axes.plot(length * profile.coordinate, factor * profile.values[0], color=PALETTE[0])
    axes.set(xlim=length * across, ylim=factor * np.array(profile.limits))
    axes.set_xlabel(name, fontsize=10)
    axes.set_ylabel(label.replace(" [", "\n["), fontsize=10)
    return line, factor * profile.values
