"""Pictures of a half-space: velocity vectors, a shaded speed, and the fronts of theory."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from granular_env.atlas.model import Arrows, Axis, Curve, Figure, Letter, Shading
from granular_env.components.grid.theory import Front, load_fronts
from granular_env.components.support.float_arrays import FloatArray

from .cases import DEPTH, HALF_WIDTH, INSTANTS, MATERIAL
from .velocity_field import Motion

# Samples of a shading, and of vectors, along the depth.
_SHADES, _ARROWS = 160, 28
# Roots of the speed, so that P is seen beside the Rayleigh wave; what is faster than this part of the grains is drawn alike.
_POWER, _MOST_PART = 0.5, 0.998
_MILLI = 1e3
_FRONTS, _SEAM = 1, 5
# How far from its front a letter stands [m].
_OFF = 0.018
# How far a picture reaches above the surface [m].
_SKY = 0.04


@dataclasses.dataclass(frozen=True)
class Window:
    """A part of the half-space that is drawn.

    Attributes:
        left: its least x [m].
        right: its greatest x [m].
        source: where the load stood [m].
        bottom: its least y [m]; the surface is at 0.
    """

    left: float = -HALF_WIDTH
    right: float = HALF_WIDTH
    source: float = 0.0
    bottom: float = -DEPTH

    def samples(self, rows: int) -> tuple[FloatArray, FloatArray]:
        """Return x and y of the middles of squares that fill it, so many along the depth."""
        size = -self.bottom / rows
        columns = round((self.right - self.left) / size)
        x, y = (np.arange(count, dtype=np.float64) + 0.5 for count in (columns, rows))
        return self.left + x * size, self.bottom + y * size


def vectors(name: str, title: str, caption: str, moving: Motion, window: Window) -> Figure:
    """Return a picture of velocity vectors."""
    x, y = (grid.ravel() for grid in np.meshgrid(*window.samples(_ARROWS)))
    velocity = _MILLI * moving.at(x, y)
    most = _most(np.hypot(velocity[:, 0], velocity[:, 1]))
    arrows = Arrows(
        f"velocity, lengths as its root; the longest {most:.0f} mm/s or more", x, y, velocity[:, 0], velocity[:, 1],
        longest=-2.2 * window.bottom / _ARROWS, most=most, power=_POWER,
    )  # fmt: skip
    return dataclasses.replace(_plane(name, title, caption, window), arrows=arrows)


def shaded(name: str, title: str, caption: str, moving: Motion, window: Window) -> Figure:
    """Return a picture of the speed as a shade."""
    x, y = window.samples(_SHADES)
    velocity = _MILLI * moving.at(*np.meshgrid(x, y))
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    shading = Shading("speed, mm/s", x, y, speed, most=_most(speed), power=_POWER)
    return dataclasses.replace(_plane(name, title, caption, window), shading=shading)


def difference(name: str, title: str, caption: str, one: Motion, other: Motion, window: Window, most: float) -> Figure:
    """Return a picture of the magnitude of the difference of two motions, in percent of `most` [m/s]."""
    x, y = window.samples(_SHADES)
    places = np.meshgrid(x, y)
    velocity = 100.0 * (one.at(*places) - other.at(*places)) / most
    shading = Shading("difference, %", x, y, np.hypot(velocity[..., 0], velocity[..., 1]))
    return dataclasses.replace(_plane(name, title, caption, window), shading=shading)


def rotation(name: str, title: str, caption: str, moving: Motion, window: Window) -> Figure:
    """Return a picture of the rate of rotation: it is 0 in P waves, and so shows S, head and Rayleigh waves alone."""
    x, y = window.samples(_SHADES)
    rate = spin(moving, *np.meshgrid(x, y))
    shading = Shading("rate of rotation, 1/s", x, y, rate, most=_most(np.abs(rate)), power=_POWER, signed=True)
    return dataclasses.replace(_plane(name, title, caption, window), shading=shading)


def spin(moving: Motion, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the rate of rotation (dv_y/dx - dv_x/dy) / 2 at points, positive against the clock [1/s]."""
    part = moving.parts[0]
    half = 0.5 * abs(part.x[1] - part.x[0])
    across = moving.at(x + half, y)[..., 1] - moving.at(x - half, y)[..., 1]
    up = moving.at(x, y + half)[..., 0] - moving.at(x, y - half)[..., 0]
    return 0.5 * (across - up) / (2.0 * half)


def _most(values: FloatArray) -> float:
    return float(np.quantile(values, _MOST_PART))


def _plane(name: str, title: str, caption: str, window: Window) -> Figure:
    fronts = load_fronts(MATERIAL, INSTANTS[-1], window.source)
    # Over the surface there is room for letters.
    curves = [Curve("", [window.left, window.right], [0.0, 0.0], "thin", _SEAM)]
    if window.left < 0.0 < window.right:
        words = "interface: grid on the left, automata on the right"
        curves.append(Curve(words, [0.0, 0.0], [window.bottom, 0.0], "line", _SEAM))
    for number, front in enumerate(fronts):
        inside = np.where(front.points[:, :1] > window.left, front.points, np.nan)
        inside = np.where(inside[:, :1] < window.right, inside, np.nan)
        label = "fronts that theory predicts" if number == 0 else ""
        curves.append(Curve(label, inside[:, 0], inside[:, 1], "dashed", _FRONTS))
    letters = [Letter("↓", window.source, 0.5 * _SKY, _SEAM)] if window.left < window.source < window.right else []
    letters += [letter for front in fronts if (letter := _letter(front, window)) is not None]
    return Figure(
        name, title, caption, Axis("x, m", window.left, window.right), Axis("y, m", window.bottom, _SKY), curves,
        letters=letters, equal=True,
    )  # fmt: skip


def _is_inside(points: FloatArray, window: Window) -> npt.NDArray[np.bool_]:
    """Tell which points lie in a window, with room for a letter beside them."""
    x, y = points[..., 0], points[..., 1]
    return (x > window.left + _OFF) & (x < window.right - _OFF) & (y > window.bottom + _OFF)


def _letter(front: Front, window: Window) -> Letter | None:
    """Return a front's name at its own place, or where the middle of it is seen; None where it is not."""
    place, direction = front.outward
    seen = front.points[_is_inside(front.points, window)]
    if not _is_inside(place, window):
        if len(seen) < 2:
            return None
        place = seen[len(seen) // 2]
        direction = place - [window.source, 0.0]
        direction /= np.linalg.norm(direction)
    x, y = place + _OFF * direction
    return Letter(front.name, float(x), float(y), _FRONTS)
