"""Axes whose planes lie closer together at a notch, their distances growing from there in geometric progression."""

from __future__ import annotations

import math

import numpy as np

from ...errors import ParameterError
from ...support.float_arrays import FloatArray
from .lattice_axis import Axis

# Largest ratio of neighbouring distances.
LARGEST_GROWTH = 1.6
_BISECTIONS = 60
_ROUNDING = 1e-9


def whole_length(axis: Axis) -> float:
    """Return the length of an axis, around a closed one its period."""
    return axis.period if axis.closed else float(axis.positions[-1])


def covers(axis: Axis, middle: float, extent: float) -> bool:
    """Return whether an interval reaches over a whole axis."""
    length = whole_length(axis)
    if axis.closed:
        return extent >= length * (1.0 - _ROUNDING)
    return middle - 0.5 * extent <= _ROUNDING * length and middle + 0.5 * extent >= (1.0 - _ROUNDING) * length


def graded_axis(even: Axis, middle: float, extent: float, spacing: float, name: str, unit: str) -> Axis:
    """Return an axis of as many planes as an even one, closer together in an interval.

    Each plane stands for the part of the axis nearest to it: those of the interval together for just the interval. Its middle
    may be an end of the axis, which is then a plane of symmetry.

    Args:
        even: planes at equal distances, from 0.
        middle: of the interval.
        extent: of the interval.
        spacing: largest distance of planes there.
        name: of the number of planes, for messages.
        unit: of the coordinate, m or rad, for messages.

    Raises:
        ParameterError: the interval lies outside, or so many planes do not resolve it.
    """
    refuse_outside(even, middle, extent, name, unit)
    if covers(even, middle, extent):
        return even
    if not extent / spacing < even.count:
        raise too_few(name, f"it takes {extent / spacing:.3g} of them at the distances of its spacing or columns")
    count = math.ceil(extent / spacing * (1.0 - _ROUNDING))
    count += 1 - count % 2
    step = extent / count
    inner: FloatArray = step * (np.arange(count, dtype=np.float64) - (count - 1) // 2)
    reach = 0.5 * (extent - step)
    if even.closed:
        steps = closing_steps(even.period - 2.0 * reach, even.count - count + 1, step, name)
        places: FloatArray = middle + np.concatenate([inner, reach + np.cumsum(steps)[:-1]])
        places = places + np.where(places < 0.0, even.period, np.where(places >= even.period, -even.period, 0.0))
        return Axis(np.sort(places), even.period)
    length = float(even.positions[-1])
    below, above = middle - reach, length - middle - reach
    if middle <= _ROUNDING * length:
        below, inner = 0.0, inner[inner >= 0.0]
    if middle >= (1.0 - _ROUNDING) * length:
        above, inner = 0.0, inner[inner <= 0.0]
    cells = even.count - len(inner)
    first, second = divided_cells(below, above, cells, step, name)
    lower, upper = growing_steps(below, first, step, name), growing_steps(above, second, step, name)
    places = np.concatenate([-reach - np.cumsum(lower)[::-1], inner, reach + np.cumsum(upper)]) + middle
    places[0], places[-1] = 0.0, length
    return Axis(places)


def refuse_outside(even: Axis, middle: float, extent: float, name: str, unit: str) -> None:
    """Raise `ParameterError` where an interval does not lie on an axis, but for one whose middle is an end."""
    length = whole_length(even)
    small = _ROUNDING * length
    at_end = not even.closed and (middle <= small or abs(middle - length) <= small)
    inside = middle - 0.5 * extent >= -small and middle + 0.5 * extent <= length + small
    if 0.0 <= middle <= length + small and (at_end or even.closed or inside):
        return
    at = ("body", "notch", "position" if name == "along" else "around")
    if not 0.0 <= middle <= length + small:
        got = f"got {middle:g} {unit} for its middle, outside of the body"
        raise ParameterError(got, expected=f"0 to {length:.7g} {unit}", at=at)
    raise ParameterError(
        f"got a notch from {middle - 0.5 * extent:.6g} to {middle + 0.5 * extent:.6g} {unit}",
        expected=f"one within 0 to {length:.6g} {unit}, or with its middle at an end that is a plane of symmetry", at=at,
    )  # fmt: skip


def divided_cells(below: float, above: float, cells: int, step: float, name: str) -> tuple[int, int]:
    """Return how many of the cells go to each side, so that distances grow about equally on both."""
    counts, lengths = [int(below > 0.0), int(above > 0.0)], (below, above)
    for _ in range(cells - sum(counts)):
        growths = [growth(length, count, step) if count else 0.0 for length, count in zip(lengths, counts, strict=True)]
        # The lower side first where both are alike, to rounding.
        counts[1 if growths[1] > growths[0] * (1.0 + _ROUNDING) else 0] += 1
    if cells < 1 or sum(counts) != cells:
        raise too_few(name, "they do not reach beyond the notch")
    return counts[0], counts[1]


def growing_steps(length: float, count: int, step: float, name: str) -> FloatArray:
    """Return so many distances that grow from a first one, of a given sum."""
    if count == 0:
        return np.zeros(0)
    ratio = growth(length, count, step)
    if ratio > LARGEST_GROWTH:
        raise too_few(name, f"distances would grow by {ratio:.3g} from plane to plane")
    steps = step * powers(ratio, count)
    return steps * (length / steps.sum())


def closing_steps(length: float, count: int, step: float, name: str) -> FloatArray:
    """Return distances around the rest of a ring, which grow towards its far side."""
    if count < 2:
        raise too_few(name, "they do not reach beyond the notch")
    ratio = growth(0.5 * length, 0.5 * count, step)
    if ratio > LARGEST_GROWTH:
        raise too_few(name, f"distances would grow by {ratio:.3g} from plane to plane")
    half = step * powers(ratio, (count + 1) // 2)
    steps = np.concatenate([half, half[::-1][count % 2 :]])
    return steps * (length / steps.sum())


def growth(length: float, count: float, step: float) -> float:
    """Return the ratio q of a progression step, step q, ..., step q^(count - 1) with a given sum, by bisection."""
    if count <= 1:
        return length / (count * step)
    low, high = 0.1, 10.0
    for _ in range(_BISECTIONS):
        ratio = 0.5 * (low + high)
        terms = powers(ratio, math.ceil(count))
        total = step * float(terms.sum() - (math.ceil(count) - count) * terms[-1])
        low, high = (ratio, high) if total < length else (low, ratio)
    return 0.5 * (low + high)


def powers(ratio: float, count: int) -> FloatArray:
    """Return 1, q, ..., q^(count - 1) by multiplication."""
    return np.multiply.accumulate(np.concatenate([[1.0], np.full(count - 1, ratio)]))


def too_few(name: str, why: str) -> ParameterError:
    """Return the error for a lattice that does not resolve a notch."""
    return ParameterError(
        f"too few nodes for the notch: {why}",
        expected=f"ratios of at most {LARGEST_GROWTH:g}", at=("body", name),
        hint="give more nodes, a larger spacing or width of the notch, or fewer columns of it",
    )  # fmt: skip
