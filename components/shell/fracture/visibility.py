"""Stencils of points beside cracks: rebuilt where a crack hides neighbours, shared with all other points elsewhere."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...support.float_arrays import FloatArray
from ..geometry.lattice import Lattice
from ..kernel_arrays import IndexArray, IntArray
from ..shape_functions import BasisName, least_squares_rows
from ..stencils import Stencils, weights_at
from .facets import LatticeTable, mark_hidden

_BASIS_SIZES = {"linear": 4, "quadratic": 10}
# Points whose functions are computed at a time: many at once would take more memory on the way than their functions.
_AT_A_TIME = 256


class Visibility:
    """Stencils of points that may lose neighbours.

    The lists of neighbours stay as they are: a hidden neighbour has the shape function 0. A point that loses one gets rows of
    its own in the tables, at their end. Points that see nothing share rows of zeros, and leave their own ones to others.

    Attributes:
        begin, lowest, offsets, kind, first, values, gradients, along: as in `Stencils`, with rows of its own for a point that
            has lost any; `gradients` and `along` are those of the stencils where nobody wants them.
    """

    def __init__(
        self, lattice: Lattice, places: Callable[[IntArray], FloatArray], stencils: Stencils, radius: float, basis: BasisName,
        has_gradients: bool = True,
    ) -> None:  # fmt: skip
        """Take what returns fractional indices of points, shape (k, 3), and their stencils without any crack."""
        self._lattice, self._places, self._stencils, self._has_gradients = lattice, places, stencils, has_gradients
        self._radius, self._basis = radius, basis
        self.begin, self.lowest, self.offsets = stencils.begin, stencils.lowest, stencils.offsets
        self._order = _bins(lattice, places(np.arange(len(stencils.kind))))
        ring = lattice.axes[1]
        period = ring.count if ring.closed else 0
        self.table = LatticeTable(ring.count, lattice.axes[2].count, period, lattice.layer_steps)
        self._slots = int(np.diff(stencils.begin.astype(np.int64)).max())
        self.clear()

    def clear(self) -> None:
        """Go back to where nothing is hidden."""
        even = self._stencils
        self.hidden = np.zeros(len(even.offsets), dtype=bool)
        self.kind, self.first = even.kind.copy(), even.first.copy()
        self.values, self.gradients, self.along = even.values, even.gradients, even.along.copy()
        # The kind of points that see nothing is the first one after those of the stencils; the next kinds belong to one point.
        self._blind = len(even.first) - 1
        self._kinds, self._rows = self._blind + 1, len(even.values) + self._slots
        # Kinds that no point has any more, by the number of their rows.
        self._left = defaultdict[int, list[int]](list)

    @property
    def seen(self) -> Stencils:
        """The stencils with the rows of the points that have lost neighbours."""
        return self._stencils._replace(
            kind=self.kind, first=self.first, values=self.values, gradients=self.gradients, along=self.along
        )

    def near(self, place: FloatArray) -> IntArray:
        """Return the points whose neighbours a facet at a place may hide."""
        lattice, reach = self._lattice, self._radius + 1.5
        along, ring = lattice.axes[:2]
        first, last = max(int(place[0] - reach), 0), min(int(place[0] + reach) + 1, along.count - 1)
        around = np.arange(int(np.floor(place[1] - reach)), int(place[1] + reach) + 2)
        around = np.unique(around % ring.count) if ring.closed else around[(around >= 0) & (around < ring.count)]
        begin, order = self._order
        cells = (np.arange(first, last + 1)[:, None] * ring.count + around).ravel()
        return np.concatenate([order[begin[cell] : begin[cell + 1]] for cell in cells]).astype(np.int64)

    def hide(self, facet: FloatArray) -> IntArray:
        """Hide neighbours behind a facet; return the points that lose any, ascending."""
        points = self.near(facet[1:4])
        return np.sort(points[: self._mark_hidden(facet, points)])

    def is_sound_behind(self, facet: FloatArray, point: int) -> bool:
        """Return whether what one point would see beside one more facet spans the basis."""
        begin, end = (int(one) for one in self._stencils.begin[point : point + 2])
        before = self.hidden[begin:end].copy()
        own = np.array([point])
        self._mark_hidden(facet, own)
        _, _, sound = self._compute(own)
        self.hidden[begin:end] = before
        return bool(sound[0])

    def _mark_hidden(self, facet: FloatArray, points: IntArray) -> int:
        """Hide what points lose to a facet, and return how many lose a neighbour; those come first in `points` then."""
        some, places = self._stencils, self._places(points)
        return int(mark_hidden(facet, self.table, some.begin, some.lowest, some.offsets, places, points, self.hidden))

    def rebuild(self, points: IntArray) -> npt.NDArray[np.bool_]:
        """Give points rows of their own, of what they see; return which of them span the basis."""
        sound = np.zeros(len(points), dtype=bool)
        for begin in range(0, len(points), _AT_A_TIME):
            some = slice(begin, begin + _AT_A_TIME)
            values, gradients, sound[some] = self._compute(points[some])
            self._write_rows(points[some], values, gradients)
        return sound

    def blind(self, points: IntArray) -> None:
        """Let points see nothing."""
        self._make_room()
        owners = np.unique(points[self.kind[points] > self._blind])
        for kind, count in zip(self.kind[owners].tolist(), self._stencils.counts(owners).tolist(), strict=True):
            self._left[count].append(kind)
        self._give_kinds(points, self._blind)

    def _write_rows(self, points: IntArray, values: FloatArray, gradients: FloatArray) -> None:
        """Give points rows of their own: shape functions (s, k) and their gradients (s, k, 3) of the neighbours."""
        self._claim_rows(points)
        begins = self.first[self.kind[points]].tolist()
        for number, (begin, count) in enumerate(zip(begins, self._stencils.counts(points).tolist(), strict=True)):
            self.values[begin : begin + count] = values[number, :count]
            if self._has_gradients:
                self.gradients[begin : begin + count] = gradients[number, :count]

    def _claim_rows(self, points: IntArray) -> None:
        """Give points rows of their own that have none."""
        self._make_room()
        fresh = points[self.kind[points] <= self._blind]
        self._give_kinds(fresh, [self._claim_kind(count) for count in self._stencils.counts(fresh).tolist()])

    def _give_kinds(self, points: IntArray, kinds: int | list[int]) -> None:
        self.kind[points] = kinds
        if self._has_gradients:
            self.along[points] = 1.0

    def _claim_kind(self, count: int) -> int:
        """Return a kind that no point has, with so many rows."""
        if self._left[count]:
            return self._left[count].pop()
        kind, self.first[self._kinds] = self._kinds, self._rows
        self._kinds, self._rows = self._kinds + 1, self._rows + count
        return kind

    def _make_room(self) -> None:
        """Make room for rows of all points, once: what is never written takes no memory, and nothing is ever moved."""
        if self.values is not self._stencils.values:
            return
        even, entries = self._stencils, self._slots + len(self.offsets)
        self.first = _with_room(even.first, len(even.kind))
        self.values = _with_room(even.values, entries)
        if self._has_gradients:
            self.gradients = _with_room(even.gradients, entries)

    def _compute(self, points: IntArray) -> tuple[FloatArray, FloatArray, npt.NDArray[np.bool_]]:
        """Return shape functions (s, k), gradients (s, k, 3) of points as they see now, and whether they span the basis."""
        some, counts = self._stencils, self._stencils.counts(points)
        slot = np.arange(int(counts.max(initial=1)))
        entry = some.begin[points].astype(np.int64)[:, None] + np.minimum(slot, counts[:, None] - 1)
        there = (slot < counts[:, None]) & ~self.hidden[entry]
        places, nodes = self._places(points), some.lowest[points, None].astype(np.int64) + some.offsets[entry]
        _, m, layers = self._lattice.shape
        around = nodes // layers % m
        if self.table.period:
            around = around + m * np.floor((places[:, 1, None] - around) / m + 0.5).astype(np.int64)
        own = [places[:, axis, None] for axis in range(3)]
        seen = [nodes // (m * layers), around, self._lattice.heights(nodes)]
        radii = self._radius, self._radius, self._lattice.reach(places, self._radius)[:, None]
        offsets, weights, slopes = weights_at(self._lattice, own, seen, there, radii)
        values, gradients = np.zeros(weights.shape), np.zeros(slopes.shape)
        sound = np.zeros(len(points), dtype=bool)
        offsets, weights, slopes = (np.ascontiguousarray(one) for one in (offsets, weights, slopes))
        least_squares_rows(offsets, weights, slopes, _BASIS_SIZES[self._basis], values, gradients, sound)
        return values, gradients, sound


def _bins(lattice: Lattice, places: FloatArray) -> tuple[IndexArray, IndexArray]:
    """Return where the points of each column of nodes begin in a list, and that list: each point is of the nearest column."""
    n, m, _ = lattice.shape
    column = lattice.nearest_columns(places)
    order = np.argsort(column, kind="stable")
    begin = np.concatenate([[0], np.cumsum(np.bincount(column, minlength=n * m))])
    return begin.astype(np.uint32), order.astype(np.uint32)


def _with_room(array: np.ndarray, rows: int) -> np.ndarray:
    """Return a copy with room for so many more rows."""
    larger = np.zeros((len(array) + rows, *array.shape[1:]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger
