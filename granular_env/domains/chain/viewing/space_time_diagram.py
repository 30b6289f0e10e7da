"""The x-t diagram as pixels for the viewer, for a whole log or a running simulation."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from granular_env.colours import diverging_colours, parse_rgb
from granular_env.components.support.float_arrays import FloatArray
from granular_env.optional_packages import import_optional
from granular_env.viewing.figures.drawing import (
    DARK,
    NOT_SAMPLED,
    draw_space_time,
    nearest_frames,
    new_figure,
    render_canvas,
    time_unit,
)
from granular_env.viewing.recorded_fields import to_field
from granular_env.viewing.scene_data import Motion

# Largest number of stored frames of a running simulation; when it is exceeded, every second frame is dropped.
_ROWS = 400


@dataclass(frozen=True)
class Picture:
    """An x-t diagram as pixels, with the location of its axes.

    Attributes:
        pixels: shape (height, width, 3), uint8.
        left, right: pixel columns of the ends of the x axis.
        bottom, top: pixel rows of the ends of the time axis (counted downwards).
        start, end: times at the rows bottom and top [s].
    """

    pixels: npt.NDArray[np.uint8]
    left: float
    right: float
    bottom: float
    top: float
    start: float
    end: float

    def pixel_rows(self, times: FloatArray) -> FloatArray:
        """Return the pixel row of each time [s]."""
        return self.bottom + (self.top - self.bottom) * (times - self.start) / (self.end - self.start)


def space_time_picture(motion: Motion, limit: float, ends: tuple[float, float] | None = None) -> Picture:
    """Return the x-t diagram on a dark background; `ends` are its first and last time [s], by default those of the motion."""
    with import_optional("matplotlib", "the x-t diagram").rc_context(DARK):
        figure = new_figure(6.4, 5.2)
        # Fixed layout: the layout engine takes longer than the drawing, and a run waits while a live view draws.
        figure.set_layout_engine("none")
        axes = figure.add_axes((0.11, 0.1, 0.84, 0.87))
        draw_space_time(figure, axes, to_field(motion), limit, ends)
        drawn = render_canvas(figure, 150)
    pixels = np.asarray(drawn.buffer_rgba())[..., :3].copy()
    box, (low, high) = axes.get_window_extent(), axes.get_ylim()
    scale, _ = time_unit(float(motion.times[-1]) if ends is None else ends[1])
    height = len(pixels)
    return Picture(pixels, box.x0, box.x1, height - box.y0, height - box.y1, low / scale, high / scale)


class GrowingPicture:
    """The x-t diagram of a running simulation: the axes are redrawn rarely, and each new frame fills in its row of pixels.

    The time axis extends to the end of the run if that is known; otherwise it is doubled when the run reaches its end.
    """

    def __init__(self, start: float, end: float | None) -> None:
        """Create an empty diagram that starts at `start` [s]; `end` is the end of the run [s], None if unknown."""
        self._start, self._end = start, end
        self._rows: list[tuple[float, npt.NDArray[np.float64]]] = []
        self._offered, self._kept_every = 0, 1
        self._axes: Picture | None = None
        self._axes_limit = 0.0

    @property
    def is_drawable(self) -> bool:
        """Return whether there is a time interval to draw."""
        return len(self._rows) > 1 and self._rows[-1][0] > self._start

    def prepare_axes(self, motion: Motion, limit: float) -> None:
        """Draw the axes in advance, so that the first frames do not wait for them."""
        self._empty_axes(motion, limit, self._start + 1e-9)

    def store_frame(self, motion: Motion) -> None:
        """Store the only frame of `motion`; when many frames are stored, only every second, fourth, ... is kept."""
        assert motion.colour is not None
        if self._offered % self._kept_every == 0:
            self._rows.append((float(motion.times[0]), motion.colour[0]))
        self._offered += 1
        if len(self._rows) > _ROWS:
            self._rows, self._kept_every = self._rows[::2], 2 * self._kept_every

    def draw_picture(self, motion: Motion, limit: float) -> Picture:
        """Return the diagram of the frames stored so far; `motion` supplies the positions of the particles."""
        axes = self._empty_axes(motion, limit, self._rows[-1][0])
        times, values = np.array([time for time, _ in self._rows]), np.stack([row for _, row in self._rows])
        pixels = axes.pixels.copy()
        top, bottom = math.ceil(axes.top), math.floor(axes.bottom)
        left, right = math.ceil(axes.left), math.floor(axes.right)
        instants = np.linspace(axes.start, axes.end, bottom - top)
        columns = np.linspace(0, values.shape[1], right - left, endpoint=False).astype(np.int64)
        frames = nearest_frames(times, instants)
        colours = diverging_colours(values[:, columns], limit)
        rows = np.where((frames >= 0)[:, None, None], colours[frames], np.array(parse_rgb(NOT_SAMPLED), np.uint8))
        pixels[top:bottom, left:right] = rows[::-1]
        return dataclasses.replace(axes, pixels=pixels)

    def _empty_axes(self, motion: Motion, limit: float, now: float) -> Picture:
        if self._axes is None or now > self._axes.end * (1.0 + 1e-9) or limit != self._axes_limit:
            if self._end is None or now > self._end * (1.0 + 1e-9):
                # The end of the run is unknown or exceeded: extend the time axis to twice the elapsed time.
                self._end = self._start + 2.0 * (now - self._start)
            nothing = np.full((2, motion.displacement.shape[1]), np.nan)
            ends = (self._start, self._end)
            empty = dataclasses.replace(motion, times=np.array(ends), colour=nothing)
            self._axes, self._axes_limit = space_time_picture(empty, limit, ends), limit
        return self._axes
