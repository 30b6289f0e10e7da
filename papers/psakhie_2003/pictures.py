"""Pictures of the half-space: velocity vectors, shaded speeds, and theoretical fronts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import PowerNorm, SymLogNorm

from granular_env.components.grid.theory import load_fronts
from granular_env.components.support.float_arrays import FloatArray
from half_space import DEPTH, HALF_WIDTH, LATE, MATERIAL, Motion
from pages import Page

# Lengths and shades scale as the root of the speed, which makes P visible next to the Rayleigh wave; the top 0.2 % are clipped.
POWER, MOST = 0.5, 0.998
LETTER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}


class Window(NamedTuple):
    """The drawn part of the half-space, and the position of the load [m]."""

    left: float = -HALF_WIDTH
    right: float = HALF_WIDTH
    source: float = 0.0
    bottom: float = -DEPTH

    def samples(self, rows: int) -> tuple[FloatArray, FloatArray]:
        """Return x and y of the centres of squares that fill the window, with `rows` squares along the depth."""
        size = -self.bottom / rows
        x = self.left + size * (np.arange(round((self.right - self.left) / size)) + 0.5)
        return tuple(np.meshgrid(x, self.bottom + size * (np.arange(rows) + 0.5)))  # type: ignore[return-value]


@contextmanager
def picture(page: Page, caption: str, window: Window) -> Iterator[Axes]:
    """Draw the interface and the theoretical fronts beneath the drawing in the body of the ``with`` statement."""
    with page.plot(caption, "x, m", "y, m", (7.5, 4.2)) as axes:
        yield axes
        axes.set(xlim=(window.left, window.right), ylim=(window.bottom, 0.04), aspect="equal")
        axes.axhline(0.0, color="0.5", linewidth=0.8)
        if window.left < 0.0 < window.right:
            axes.plot([0.0, 0.0], [window.bottom, 0.0], color="0.5", linewidth=0.8)
        if window.left < window.source < window.right:
            axes.annotate("", (window.source, 0.0), (window.source, 0.035), arrowprops={"arrowstyle": "->"})
        for front in load_fronts(MATERIAL, LATE, window.source):
            axes.plot(*front.points.T, "--", color="C1", linewidth=0.9)
            x, y = front.outward[0] + 0.018 * front.outward[1]
            if window.left < x < window.right and y > window.bottom:
                axes.text(x, y, front.name, color="C1", ha="center", va="center", bbox=LETTER)


def draw_vectors(page: Page, caption: str, moving: Motion, window: Window) -> None:
    """Draw velocity vectors with lengths proportional to the root of the speed."""
    with picture(page, caption, window) as axes:
        x, y = window.samples(28)
        velocity = moving.velocity_at(x, y)
        speed = np.hypot(velocity[..., 0], velocity[..., 1])
        length = (speed / np.quantile(speed, MOST)).clip(0.0, 1.0) ** POWER * 2.2 * -window.bottom / 28
        u, v = (length * velocity[..., axis] / np.maximum(speed, 1e-30) for axis in (0, 1))
        axes.quiver(x, y, u, v, angles="xy", scale_units="xy", scale=1.0, width=0.0015)


def draw_shade(page: Page, caption: str, label: str, values: FloatArray, window: Window, signed: bool = False) -> None:
    """Draw a quantity at ``window.samples(160)`` as shading."""
    with picture(page, caption, window) as axes:
        most = float(np.quantile(np.abs(values), MOST))
        norm = SymLogNorm(0.05 * most, vmin=-most, vmax=most) if signed else PowerNorm(POWER, vmin=0.0, vmax=most)
        x, y = window.samples(160)
        shade = axes.pcolormesh(x, y, values, norm=norm, cmap="PuOr" if signed else "Blues", rasterized=True)
        axes.figure.colorbar(shade, ax=axes, label=label, shrink=0.8)


def draw_speed(page: Page, caption: str, moving: Motion, window: Window) -> None:
    """Draw the speed as shading."""
    velocity = 1e3 * moving.velocity_at(*window.samples(160))
    draw_shade(page, caption, "speed, mm/s", np.hypot(velocity[..., 0], velocity[..., 1]), window)
