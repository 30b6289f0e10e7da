"""One axis of a lattice of nodes (along, around or through the body): where its planes lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]
# Distance of neighbouring planes over their coordinate, from which on rounding does not spoil gradients.
_LEAST_DISTANCE = 1e-6


@dataclass(frozen=True)
class Axis:
    """Coordinates of the planes of nodes along one direction; between them index and coordinate go linearly.

    Attributes:
        positions: shape (n,), increasing [m, or rad around a tube].
        period: after which the first plane follows the last one; 0 where the axis has two ends.
    """

    positions: FloatArray
    period: float = 0.0

    @property
    def count(self) -> int:
        """Number of planes."""
        return len(self.positions)

    @property
    def closed(self) -> bool:
        """True where it has no ends."""
        return self.period > 0.0

    @property
    def bounds(self) -> FloatArray:
        """The ends of the parts that belong to each plane: half way to its neighbours, shape (n + 1,)."""
        x = self.positions
        middle = 0.5 * (x[1:] + x[:-1])
        if self.closed:
            seam = 0.5 * (x[-1] + x[0] + self.period)
            return np.concatenate([[seam - self.period], middle, [seam]])
        return np.concatenate([x[:1], middle, x[-1:]])

    @property
    def widths(self) -> FloatArray:
        """Length of the part that belongs to each plane, shape (n,)."""
        return np.diff(self.bounds)

    def at(self, index: FloatArray) -> FloatArray:
        """Return the coordinate at fractional indices."""
        return np.interp(index, *self._extended(self.positions, self.period))

    def at_any(self, planes: IntArray) -> FloatArray:
        """Return the coordinates of planes that may be counted on beyond the seam."""
        return self.positions[planes % self.count] + self.period * (planes // self.count)

    def slope(self, index: FloatArray) -> FloatArray:
        """Return how fast the coordinate grows with the index."""
        return np.interp(index, *self._extended(self._slopes(), 0.0))

    def _slopes(self) -> FloatArray:
        """Return differences between the neighbours of each plane over two; at ends that to the only one."""
        _, x = self._extended(self.positions, self.period)
        if self.closed:
            return 0.5 * (x[2:] - x[:-2])
        step = np.diff(x)
        return np.concatenate([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]])

    def _extended(self, values: FloatArray, jump: float) -> tuple[FloatArray, FloatArray]:
        """Return indices and values, of a closed axis with one more on each side."""
        if not self.closed:
            return np.arange(self.count, dtype=np.float64), values
        return np.arange(-1.0, self.count + 1.0), np.concatenate([[values[-1] - jump], values, [values[0] + jump]])

    def neighbours(self, index: float, radius: float) -> list[int]:
        """Return the planes nearer to an index than the radius, counted on beyond the seam of a closed axis."""
        first, last = int(np.ceil(index - radius)), int(np.floor(index + radius))
        found = [plane for plane in range(first, last + 1) if abs(plane - index) < radius]
        return found if self.closed else [plane for plane in found if 0 <= plane < self.count]


def even_axis(length: float, count: int) -> Axis:
    """Return planes at equal distances from 0 to a length."""
    return Axis(length * np.arange(count) / (count - 1))


def closed_axis(period: float, count: int) -> Axis:
    """Return planes at equal distances around a ring."""
    return Axis(period * np.arange(count) / count, period)


def refuse_coinciding(axis: Axis, given: float, *name: str) -> None:
    """Raise `ParameterError` where rounding does not keep planes of an axis apart.

    Args:
        axis: its planes in ascending order.
        given: the measure of the body from which their distances follow [m].
        name: of that measure, in the body.
    """
    x = axis.positions
    distance, largest = float(np.diff(x).min()), float(np.abs(x).max())
    if not distance >= _LEAST_DISTANCE * largest:
        raise ParameterError(
            f"got {given:g} m: two planes of nodes would lie {distance:g} apart at {largest:g}",
            expected=f"distances of at least {_LEAST_DISTANCE:g} of the coordinate", at=("body", *name),
        )  # fmt: skip
