"""One axis of a lattice of nodes (along, around or through the body), with planes at equal distances or graded at a notch."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]
# Smallest ratio of a distance of neighbouring planes to their coordinate; below it rounding would spoil gradients.
_LEAST_DISTANCE = 1e-6
# Largest allowed ratio of successive distances between planes.
LARGEST_GROWTH = 1.6
_BISECTIONS = 60
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Axis:
    """Coordinates of the planes of nodes along one direction; between planes the coordinate is linear in the index.

    Attributes:
        positions: coordinate of each plane, shape (n,), increasing [m, or rad around a tube].
        period: length after which the planes repeat (around a closed axis); 0 for an axis with two ends.
    """

    positions: FloatArray
    period: float = 0.0

    @property
    def count(self) -> int:
        """Number of planes."""
        return len(self.positions)

    @property
    def is_closed(self) -> bool:
        """True for an axis without ends."""
        return self.period > 0.0

    @property
    def length(self) -> float:
        """Length of the axis; its period if it is closed."""
        return self.period if self.is_closed else float(self.positions[-1])

    @property
    def bounds(self) -> FloatArray:
        """Bounds of the interval that each plane represents, halfway between neighbours, shape (n + 1,)."""
        x = self.positions
        middle = 0.5 * (x[1:] + x[:-1])
        if self.is_closed:
            seam = 0.5 * (x[-1] + x[0] + self.period)
            return np.concatenate([[seam - self.period], middle, [seam]])
        return np.concatenate([x[:1], middle, x[-1:]])

    @property
    def widths(self) -> FloatArray:
        """Length of the interval that each plane represents, shape (n,)."""
        return np.diff(self.bounds)

    def coordinates(self, index: FloatArray) -> FloatArray:
        """Return the coordinates at fractional indices."""
        return np.interp(index, *self._interpolation_table(self.positions, self.period))

    def plane_coordinates(self, planes: IntArray) -> FloatArray:
        """Return the coordinates of planes, whose numbers may continue beyond the seam of a closed axis."""
        return self.positions[planes % self.count] + self.period * (planes // self.count)

    def slope(self, index: FloatArray) -> FloatArray:
        """Return the derivative of the coordinate with respect to the index."""
        return np.interp(index, *self._interpolation_table(self._plane_slopes(), 0.0))

    def _plane_slopes(self) -> FloatArray:
        """Return half the distance between the neighbours of each plane; at ends the distance to the only neighbour."""
        _, x = self._interpolation_table(self.positions, self.period)
        if self.is_closed:
            return 0.5 * (x[2:] - x[:-2])
        step = np.diff(x)
        return np.concatenate([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]])

    def _interpolation_table(self, values: FloatArray, jump: float) -> tuple[FloatArray, FloatArray]:
        """Return indices and values for interpolation; a closed axis has one more value on each side, changed by `jump`."""
        if not self.is_closed:
            return np.arange(self.count, dtype=np.float64), values
        return np.arange(-1.0, self.count + 1.0), np.concatenate([[values[-1] - jump], values, [values[0] + jump]])

    def neighbours(self, index: float, radius: float) -> list[int]:
        """Return the planes nearer to an index than the radius; numbers continue beyond the seam of a closed axis."""
        first, last = int(np.ceil(index - radius)), int(np.floor(index + radius))
        found = [plane for plane in range(first, last + 1) if abs(plane - index) < radius]
        return found if self.is_closed else [plane for plane in found if 0 <= plane < self.count]

    def is_covered(self, middle: float, extent: float) -> bool:
        """Return whether an interval (its middle and extent) covers the whole axis."""
        if self.is_closed:
            return extent >= self.length * (1.0 - _ROUNDING)
        first, last = middle - 0.5 * extent, middle + 0.5 * extent
        return first <= _ROUNDING * self.length and last >= (1.0 - _ROUNDING) * self.length


def even_axis(length: float, count: int) -> Axis:
    """Return planes at equal distances from 0 to `length`."""
    return Axis(length * np.arange(count) / (count - 1))


def closed_axis(period: float, count: int) -> Axis:
    """Return planes at equal distances around a ring."""
    return Axis(period * np.arange(count) / count, period)


def refuse_coinciding_planes(axis: Axis, measure: float, *name: str) -> None:
    """Raise `ParameterError` if rounding errors could make planes of an axis coincide.

    Args:
        axis: axis with its planes in ascending order.
        measure: the measure of the body that determines their distances [m].
        name: name of this measure in the parameters of the body.
    """
    x = axis.positions
    distance, largest = float(np.diff(x).min()), float(np.abs(x).max())
    if not distance >= _LEAST_DISTANCE * largest:
        raise ParameterError(
            f"got {measure:g} m: two planes of nodes would be only {distance:g} apart at the coordinate {largest:g}",
            expected=f"distances of at least {_LEAST_DISTANCE:g} times the coordinate", at=("body", *name),
        )  # fmt: skip


def graded_axis(base_axis: Axis, middle: float, extent: float, spacing: float, name: str, unit: str) -> Axis:
    """Return an axis with the same number of planes as an even one, closer together in an interval.

    Each plane represents the part of the axis nearest to it; the planes in the interval together represent the interval.
    The middle of the interval may be an end of the axis, which is then a plane of symmetry.

    Args:
        base_axis: planes at equal distances, from 0.
        middle: of the interval.
        extent: of the interval.
        spacing: largest distance of planes in the interval.
        name: of the number of planes, for messages.
        unit: of the coordinate, m or rad, for messages.

    Raises:
        ParameterError: the interval lies outside the axis, or the planes do not resolve it.
    """
    refuse_outside_interval(base_axis, middle, extent, name, unit)
    if base_axis.is_covered(middle, extent):
        return base_axis
    if not extent / spacing < base_axis.count:
        raise unresolved_notch_error(name, f"its spacing or columns require {extent / spacing:.3g} nodes inside it")
    count = math.ceil(extent / spacing * (1.0 - _ROUNDING))
    count += 1 - count % 2
    step = extent / count
    inner: FloatArray = step * (np.arange(count, dtype=np.float64) - (count - 1) // 2)
    reach = 0.5 * (extent - step)
    if base_axis.is_closed:
        steps = closing_steps(base_axis.period - 2.0 * reach, base_axis.count - count + 1, step, name)
        places: FloatArray = middle + np.concatenate([inner, reach + np.cumsum(steps)[:-1]])
        places = places + np.where(places < 0.0, base_axis.period, np.where(places >= base_axis.period, -base_axis.period, 0.0))
        return Axis(np.sort(places), base_axis.period)
    length = base_axis.length
    below, above = middle - reach, length - middle - reach
    if middle <= _ROUNDING * length:
        below, inner = 0.0, inner[inner >= 0.0]
    if middle >= (1.0 - _ROUNDING) * length:
        above, inner = 0.0, inner[inner <= 0.0]
    cells = base_axis.count - len(inner)
    first, second = divide_cells(below, above, cells, step, name)
    lower, upper = growing_steps(below, first, step, name), growing_steps(above, second, step, name)
    places = np.concatenate([-reach - np.cumsum(lower)[::-1], inner, reach + np.cumsum(upper)]) + middle
    places[0], places[-1] = 0.0, length
    return Axis(places)


def refuse_outside_interval(base_axis: Axis, middle: float, extent: float, name: str, unit: str) -> None:
    """Raise `ParameterError` for an interval outside the axis; an interval centred on an end may extend beyond this end."""
    length, low, high, small = base_axis.length, middle - 0.5 * extent, middle + 0.5 * extent, _ROUNDING * base_axis.length
    if base_axis.is_closed:
        inside = middle <= length + small and extent <= length + small
    elif min(middle, abs(length - middle)) <= small:
        inside = 0.5 * extent <= length + small
    else:
        inside = low >= -small and high <= length + small
    if not inside:
        raise ParameterError(
            f"got a notch from {low:.6g} to {high:.6g} {unit}",
            expected=f"a notch within 0 to {length:.6g} {unit}, or centred on an end that is a plane of symmetry",
            at=("body", "notch", "position" if name == "along" else "around"),
        )


def divide_cells(below: float, above: float, cells: int, step: float, name: str) -> tuple[int, int]:
    """Return the numbers of cells below and above a notch for which distances grow about equally on both sides."""
    counts, lengths = [int(below > 0.0), int(above > 0.0)], (below, above)
    for _ in range(cells - sum(counts)):
        growths = [growth_ratio(length, count, step) if count else 0.0 for length, count in zip(lengths, counts, strict=True)]
        # If both growths are equal, to rounding, the lower side gets the cell.
        counts[1 if growths[1] > growths[0] * (1.0 + _ROUNDING) else 0] += 1
    if cells < 1 or sum(counts) != cells:
        raise unresolved_notch_error(name, "too few remain outside it")
    return counts[0], counts[1]


def growing_steps(length: float, count: int, step: float, name: str) -> FloatArray:
    """Return `count` distances whose sum is `length`, which grow from the first distance `step`."""
    if count == 0:
        return np.zeros(0)
    steps = step * ratio_powers(refuse_large_growth(growth_ratio(length, count, step), name), count)
    return steps * (length / steps.sum())


def closing_steps(length: float, count: int, step: float, name: str) -> FloatArray:
    """Return `count` distances around the rest of a ring, with the sum `length`, which grow towards its far side."""
    if count < 2:
        raise unresolved_notch_error(name, "too few remain outside it")
    ratio = refuse_large_growth(growth_ratio(0.5 * length, 0.5 * count, step), name)
    half = step * ratio_powers(ratio, (count + 1) // 2)
    steps = np.concatenate([half, half[::-1][count % 2 :]])
    return steps * (length / steps.sum())


def refuse_large_growth(ratio: float, name: str) -> float:
    """Return a ratio of neighbouring distances if it is allowed; raise `ParameterError` if it is too large."""
    if ratio > LARGEST_GROWTH:
        raise unresolved_notch_error(name, f"distances would grow by a factor of {ratio:.3g} from plane to plane")
    return ratio


def growth_ratio(length: float, count: float, step: float) -> float:
    """Return the ratio q for which step, step q, ..., step q^(count - 1) have the sum `length`, by bisection."""
    if count <= 1:
        return length / (count * step)
    low, high = 0.1, 10.0
    for _ in range(_BISECTIONS):
        ratio = 0.5 * (low + high)
        terms = ratio_powers(ratio, math.ceil(count))
        total = step * float(terms.sum() - (math.ceil(count) - count) * terms[-1])
        low, high = (ratio, high) if total < length else (low, ratio)
    return 0.5 * (low + high)


def ratio_powers(ratio: float, count: int) -> FloatArray:
    """Return 1, q, ..., q^(count - 1) by repeated multiplication."""
    return np.multiply.accumulate(np.concatenate([[1.0], np.full(count - 1, ratio)]))


def unresolved_notch_error(name: str, reason: str) -> ParameterError:
    """Return the error for a lattice that does not resolve a notch."""
    return ParameterError(
        f"too few nodes for the notch: {reason}",
        expected=f"growth factors of at most {LARGEST_GROWTH:g}", at=("body", name),
        hint="give more nodes, a larger spacing or width of the notch, or fewer columns in it",
    )  # fmt: skip
