"""Colours of all pictures: a map for signed values, a map for values without a sign, and a colour-blind safe line palette."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .components.support.float_arrays import FloatArray
from .components.variables import Variable

# Map for signed values: blue, near white, red (ColorBrewer RdBu without its darkest ends, invisible on a dark background).
DIVERGING = ("#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7", "#fddbc7", "#f4a582", "#d6604d", "#b2182b")
# Map for quantities without a sign: dark to light yellow (similar to a part of matplotlib's "cividis").
SEQUENTIAL = ("#3b4a6b", "#666970", "#958f78", "#c8b866", "#fee838")
# Line colours: Okabe and Ito's palette without black and yellow, then wine, teal, grey and violet. These four differ from the
# others and from each other as clearly as the palette's, also for the colour-blind, and are visible on white and on dark.
PALETTE = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#960f3c", "#006969", "#a5b4a5", "#4b0fe1",
)  # fmt: skip
# Values that exceed this quantile of the magnitudes by this factor are outstanding; see `colour_limit`.
_NEARLY_ALL, _OUTSTANDING = 0.995, 2.5


def parse_rgb(text: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of ``#rrggbb``."""
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def _interpolate_colours(fraction: npt.NDArray[np.float64], anchors: tuple[str, ...]) -> npt.NDArray[np.uint8]:
    table = np.array([parse_rgb(anchor) for anchor in anchors], dtype=np.float64)
    places = np.linspace(0.0, 1.0, len(anchors))
    fraction = np.clip(np.nan_to_num(fraction, nan=0.5), 0.0, 1.0)
    channels = [np.interp(fraction, places, table[:, channel]) for channel in range(3)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)


def diverging_colours(values: npt.NDArray[np.float64], limit: float, zero: str | None = None) -> npt.NDArray[np.uint8]:
    """Return the colours of signed values, from blue at -limit to red at +limit, shape (*values.shape, 3).

    Args:
        values: the signed values, an array of any shape.
        limit: magnitude of the values at the two ends of the colour map.
        zero: the colour of 0, such as a grey that is visible on white; default: near white.
    """
    anchors = DIVERGING if zero is None else (DIVERGING[0], zero, DIVERGING[-1])
    return _interpolate_colours(0.5 + 0.5 * np.asarray(values) / limit, anchors)


def sequential_colours(values: npt.NDArray[np.float64], limit: float) -> npt.NDArray[np.uint8]:
    """Return the colours of values from 0 (dark) to limit (yellow); shape (*values.shape, 3)."""
    return _interpolate_colours(np.asarray(values) / limit, SEQUENTIAL)


def colour_limit(values: npt.NDArray[np.float64], clips: bool) -> float:
    """Return the `symmetric_limit` of finite values; with `clips`, without a few values far above all others.

    In a plane, the values at the place of a point load would otherwise leave the wave nearly without colour.
    """
    magnitudes = np.abs(values)
    largest = float(magnitudes.max(initial=0.0))
    if clips and largest > 0.0:
        nearly_all = float(np.quantile(magnitudes[magnitudes > 0.0], _NEARLY_ALL))
        largest = nearly_all if largest > _OUTSTANDING * nearly_all else largest
    return symmetric_limit([largest])


def symmetric_limit(values: npt.ArrayLike) -> float:
    """Return the colour limit for signed values: the largest magnitude rounded up to two digits, or 1 if all are zero."""
    array = np.abs(np.asarray(values, dtype=np.float64))
    finite = array[np.isfinite(array)]
    largest = float(finite.max()) if finite.size else 0.0
    if largest <= 0.0:
        return 1.0
    decade = 10.0 ** (math.floor(math.log10(largest)) - 1)
    # Subtract a small tolerance before rounding up, so that a rounding error of the division does not turn 50 into 51.
    return float(f"{math.ceil(largest / decade - 1e-9) * decade:.6g}")


@dataclass(frozen=True)
class ColourScale:
    """A colour scale for one output, or for several outputs of one unit.

    Attributes:
        names: names of the outputs.
        unit: unit of the outputs.
        limit: magnitude at the ends of the colour scale.
        has_sign: whether any value is negative.
        is_exceeded: whether some values exceed the limit, so that they get the colour of the limit.
        is_zero: whether all values are zero, so that the limit is arbitrary.
    """

    names: tuple[str, ...]
    unit: str
    limit: float
    has_sign: bool
    is_exceeded: bool = False
    is_zero: bool = False


def colour_scales(shown: Iterable[tuple[Variable, FloatArray]], is_plane: bool = False) -> tuple[ColourScale, ...]:
    """Return the colour scales of outputs: one per unit, and one per output without a unit.

    Args:
        shown: for each output its variable and its values, of any shape.
        is_plane: whether the shapes lie in a plane, where a few outstanding values do not set the limit.
    """
    groups: dict[str, list[tuple[Variable, FloatArray]]] = {}
    for variable, values in shown:
        groups.setdefault(variable.name if variable.unit == "1" else variable.unit, []).append((variable, values))
    return tuple(_make_scale(group, is_plane) for group in groups.values())


def _make_scale(group: Sequence[tuple[Variable, FloatArray]], is_plane: bool) -> ColourScale:
    values = np.concatenate([np.ravel(values) for _, values in group])
    values, unit = values[np.isfinite(values)], group[0][0].unit
    names = tuple(dict.fromkeys(variable.name for variable, _ in group))
    limit = colour_limit(values, clips=is_plane and unit != "1")
    is_exceeded = bool(np.abs(values).max(initial=0.0) > 1.01 * limit)  # more than by rounding
    return ColourScale(names, unit, limit, bool(values.min(initial=0.0) < 0.0), is_exceeded, not values.any())
