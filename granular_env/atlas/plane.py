"""The parts of a figure that lie in a plane: a shaded quantity with its scale, vectors, and letters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.colours import PALETTE, rgb
from granular_env.optional_packages import import_optional

from .model import Arrows, Figure, Letter, Shading

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Ink of a shade: of magnitudes, and of positive and negative values. Dark pages invert its lightness.
_INK, _POSITIVE, _NEGATIVE = "#000000", PALETTE[1], PALETTE[0]
# Of arrows: a colour that the page has a lighter one of, for the dark.
_ARROW = PALETTE[0]
_SCALE_ROWS, _SCALE_TICKS, _SMALL_TICK = 128, 5, 0.2
# Arrows that are shorter than this part of the longest one have no direction that could be seen.
_SHORTEST = 0.02
# Around a plane of equal axes, in points: names and numbers of the axes, and the scale.
_BESIDE, _ABOVE_AND_BELOW = 62.0, 52.0
_SCALE_WIDTH = 58.0


def height_of_plane(figure: Figure, width: float) -> float:
    """Return the height of a drawing of this width [pt] in which a length is as long along both axes."""
    across, up = (_extent(axis.low, axis.high, figure.name) for axis in (figure.x, figure.y))
    inside = width - _BESIDE - (_SCALE_WIDTH if figure.shading else 0.0)
    return inside * up / across + _ABOVE_AND_BELOW


def _extent(low: float | None, high: float | None, name: str) -> float:
    if low is None or high is None:
        raise ValueError(f"figure {name!r}: equal axes need their limits; give both axes low and high")
    return high - low


def draw_shading(axes: Axes, shading: Shading) -> None:
    """Draw a quantity over the plane, and its scale to the right."""
    x, y, values = (np.asarray(one, dtype=np.float64) for one in (shading.x, shading.y, shading.values))
    most = _most(np.abs(values), shading.most)
    # The first and last samples stand in the middle of their columns and rows.
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    axes.imshow(_ink(values, most, shading), origin="lower", extent=extent, interpolation="bicubic", aspect="auto")
    axes.grid(False)
    _draw_scale(axes, shading, most)


def _ink(values: Any, most: float, shading: Shading) -> Any:
    """Return red, green, blue and opacity of each sample, shape (rows, columns, 4)."""
    inks = (_POSITIVE, _NEGATIVE) if shading.signed else (_INK, _INK)
    positive, negative = (np.array(rgb(ink)) / 255.0 for ink in inks)
    colours = np.where((values >= 0.0)[..., None], positive, negative)
    opacity = _darkness(np.abs(np.nan_to_num(values)), most, shading.power)
    return np.concatenate([colours, opacity[..., None]], axis=-1)


def _darkness(magnitude: Any, most: float, power: float) -> Any:
    return np.minimum(magnitude / most, 1.0) ** power


def _draw_scale(axes: Axes, shading: Shading, most: float) -> None:
    """Draw which shade means what; its ticks stand where the shades of round numbers are."""
    low = -1.0 if shading.signed else 0.0
    places = np.linspace(low, 1.0, _SCALE_ROWS)
    values = np.sign(places) * np.abs(places) ** (1.0 / shading.power) * most
    scale = axes.inset_axes((1.02, 0.0, 0.03, 1.0))
    scale.imshow(
        _ink(values[:, None], most, shading),
        origin="lower",
        extent=(0.0, 1.0, low, 1.0),
        interpolation="bilinear",
        aspect="auto",
    )
    ticks = import_optional("matplotlib.ticker", "the atlas").MaxNLocator(_SCALE_TICKS, steps=[1, 2, 5, 10])
    numbers = [float(one) for one in ticks.tick_values(low * most, most) if abs(one) <= most * (1.0 + 1e-9)]
    if shading.power < 1.0:
        # Roots spread small numbers: one more stands where there is room for it.
        small = _SMALL_TICK * min(one for one in numbers if one > 0.0)
        numbers += [small, -small] if shading.signed else [small]
    at = [float(np.sign(one) * _darkness(abs(one), most, shading.power)) for one in numbers]
    scale.set_yticks(at, [f"{one:g}".replace("-", "\u2212") for one in numbers])
    scale.yaxis.tick_right()
    scale.yaxis.set_label_position("right")
    scale.set(xticks=[], ylabel=shading.label)
    scale.grid(False)


def draw_arrows(axes: Axes, arrows: Arrows) -> None:
    """Draw vectors; what is too short to have a direction is left out."""
    x, y, u, v = (np.asarray(one, dtype=np.float64).ravel() for one in (arrows.x, arrows.y, arrows.u, arrows.v))
    magnitude = np.hypot(u, v)
    most = _most(magnitude, arrows.most)
    length = _darkness(magnitude, most, arrows.power)
    seen = length > _SHORTEST
    scale = arrows.longest * length[seen] / magnitude[seen]
    axes.quiver(
        x[seen], y[seen], u[seen] * scale, v[seen] * scale, angles="xy", scale_units="xy", scale=1.0, pivot="middle",
        width=0.0016, headwidth=3.6, headlength=4.2, headaxislength=3.8, minlength=0.0, minshaft=1.0, color=_ARROW,
    )  # fmt: skip


def _most(magnitude: Any, given: float | None) -> float:
    """Return the magnitude that is drawn fullest; 1 where all is zero."""
    return given or float(np.nanmax(magnitude, initial=0.0)) or 1.0


def draw_letter(axes: Axes, letter: Letter) -> None:
    """Draw the name of a place, its middle there."""
    colour = PALETTE[letter.colour % len(PALETTE)]
    axes.text(letter.x, letter.y, letter.text, color=colour, fontweight="bold", fontsize=14.0, ha="center", va="center")
