"""Stencils (neighbours and shape functions) of points at cracks: rebuilt where a crack hides neighbours, shared elsewhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...support.float_arrays import FloatArray
from ..geometry.lattice import Lattice
from ..kernel_arrays import IndexArray, IntArray
from ..shape_functions import BasisName, least_squares_rows
from ..stencils import Stencils, point_weights
from .facets import crosses_facet, nearest_period_multiple

_BASIS_SIZES = {"linear": 4, "quadratic": 10}
# Shape functions are computed for this many points at a time, to limit temporary memory.
_AT_A_TIME = 256


class Visibility:
    """Stencils of points that may lose neighbours.

    The lists of neighbours do not change: a hidden neighbour has the shape function 0. The shape functions are stored in rows:
    first those of the stencils without cracks, then zeros for points without neighbours, then own rows of each point.

    Attributes:
        hidden: whether each entry of the lists of neighbours is hidden, shape (entries,).
        seen: the stencils after cracks; without gradients if the given ones have none.
    """

    def __init__(
        self, lattice: Lattice, places: Callable[[IntArray], FloatArray], stencils: Stencils, radius: float, basis: BasisName
    ) -> None:
        """Build from a function that returns the fractional indices of points, (k, 3), and their stencils without cracks."""
        self._lattice, self._places, self._even, self._radius, self._basis = lattice, places, stencils, radius, basis
        self._order = _column_bins(lattice, places(np.arange(len(stencils.kind))))
        self._period = lattice.shape[1] if lattice.axes[1].is_closed else 0
        self._slots = int(np.diff(stencils.begin.astype(np.int64)).max())
        self.clear()

    def clear(self) -> None:
        """Return to a state in which no neighbour is hidden."""
        self.hidden = np.zeros(len(self._even.nodes), dtype=bool)
        self.seen = self._even

    def nearby_points(self, place: FloatArray) -> IntArray:
        """Return the points near a place in index space, of which a facet there may hide neighbours."""
        lattice, reach = self._lattice, self._radius + 1.5
        along, ring = lattice.axes[:2]
        first, last = max(int(place[0] - reach), 0), min(int(place[0] + reach) + 1, along.count - 1)
        around = np.arange(int(np.floor(place[1] - reach)), int(place[1] + reach) + 2)
        around = np.unique(around % ring.count) if ring.is_closed else around[(around >= 0) & (around < ring.count)]
        begin, order = self._order
        cells = (np.arange(first, last + 1)[:, None] * ring.count + around).ravel()
        return np.concatenate([order[begin[cell] : begin[cell + 1]] for cell in cells]).astype(np.int64)

    def hide_neighbours(self, facet: FloatArray) -> IntArray:
        """Hide neighbours behind a facet; return the points that lose neighbours, ascending."""
        return self._mark_hidden(facet, self.nearby_points(facet[1:4]))

    def is_spanned_behind(self, facet: FloatArray, point: int) -> bool:
        """Return whether the neighbours that a point would keep after one more facet still span the basis of its functions."""
        begin, end = (int(one) for one in self._even.begin[point : point + 2])
        before = self.hidden[begin:end].copy()
        own = np.array([point])
        self._mark_hidden(facet, own)
        _, _, sound = self._compute_functions(own)
        self.hidden[begin:end] = before
        return bool(sound[0])

    def _mark_hidden(self, facet: FloatArray, points: IntArray) -> IntArray:
        """Hide the neighbours of points behind a facet; return the points that lose a neighbour, ascending."""
        counts = self._even.neighbour_counts(points)
        owner = np.repeat(np.arange(len(points)), counts)
        entry = np.arange(len(owner)) + np.repeat(
            self._even.begin[points].astype(np.int64) - np.cumsum(counts) + counts, counts
        )
        visible = ~self.hidden[entry]
        owner, entry = owner[visible], entry[visible]
        own, nodes = self._places(points)[owner], self._lattice.indices(self._even.nodes[entry].astype(np.int64))
        if self._period:
            nodes[:, 1] += nearest_period_multiple(own[:, 1] - nodes[:, 1], self._period)
        lost = crosses_facet(facet, self._period, own, nodes)
        self.hidden[entry[lost]] = True
        return np.unique(points[owner[lost]])

    def rebuild_stencils(self, points: IntArray) -> npt.NDArray[np.bool_]:
        """Compute the functions of points with their remaining neighbours; return for which points these span the basis."""
        sound = np.zeros(len(points), dtype=bool)
        self._set_stencil_numbers(points, len(self._even.first) + points)
        for begin in range(0, len(points), _AT_A_TIME):
            some = points[begin : begin + _AT_A_TIME]
            values, gradients, sound[begin : begin + len(some)] = self._compute_functions(some)
            slot = np.arange(values.shape[1])
            there = slot < self._even.neighbour_counts(some)[:, None]
            rows = (self.seen.first[self.seen.kind[some]].astype(np.int64)[:, None] + slot)[there]
            self.seen.values[rows] = values[there]
            if len(self.seen.gradients):
                self.seen.gradients[rows] = gradients[there]
        return sound

    def remove_neighbours(self, points: IntArray) -> None:
        """Remove all neighbours of some points."""
        self._set_stencil_numbers(points, len(self._even.first) - 1)

    def _set_stencil_numbers(self, points: IntArray, kinds: IntArray | int) -> None:
        """Set the stencil numbers of points; allocate own rows of all points at the first call."""
        even = self._even
        if self.seen is even:
            # Allocated rows that are never written take no physical memory.
            room, own = self._slots + len(even.nodes), len(even.values) + self._slots + even.begin[:-1]
            self.seen = even._replace(
                kind=even.kind.copy(), first=np.concatenate([even.first, own]).astype(np.uint32), along=even.along.copy(),
                values=_enlarged_copy(even.values, room),
                gradients=_enlarged_copy(even.gradients, room) if len(even.gradients) else even.gradients,
            )  # fmt: skip
        self.seen.kind[points] = kinds
        if len(even.along):
            self.seen.along[points] = 1.0

    def _compute_functions(self, points: IntArray) -> tuple[FloatArray, FloatArray, npt.NDArray[np.bool_]]:
        """Return functions (s, k), gradients (s, k, 3) of points with present neighbours, and whether these span the basis."""
        some, counts = self._even, self._even.neighbour_counts(points)
        slot = np.arange(int(counts.max(initial=1)))
        entry = some.begin[points].astype(np.int64)[:, None] + np.minimum(slot, counts[:, None] - 1)
        there = (slot < counts[:, None]) & ~self.hidden[entry]
        places, nodes = self._places(points), some.nodes[entry].astype(np.int64)
        _, m, layers = self._lattice.shape
        around = nodes // layers % m
        if self._period:
            around = around + nearest_period_multiple(places[:, 1, None] - around, m).astype(np.int64)
        own = [places[:, axis, None] for axis in range(3)]
        seen = [nodes // (m * layers), around, self._lattice.heights(nodes)]
        radii = self._radius, self._radius, self._lattice.support_radius(places, self._radius)[:, None]
        offsets, weights, slopes = map(np.ascontiguousarray, point_weights(self._lattice, own, seen, there, radii))
        values, gradients = np.zeros(weights.shape), np.zeros(slopes.shape)
        sound = np.zeros(len(points), dtype=bool)
        least_squares_rows(offsets, weights, slopes, _BASIS_SIZES[self._basis], values, gradients, sound)
        return values, gradients, sound


def _column_bins(lattice: Lattice, places: FloatArray) -> tuple[IndexArray, IndexArray]:
    """Return where the points of each column begin in a list, and this list; a point belongs to its nearest column."""
    n, m, _ = lattice.shape
    column = lattice.nearest_columns(places)
    order = np.argsort(column, kind="stable")
    begin = np.concatenate([[0], np.cumsum(np.bincount(column, minlength=n * m))])
    return begin.astype(np.uint32), order.astype(np.uint32)


def _enlarged_copy(array: np.ndarray, rows: int) -> np.ndarray:
    """Return a copy with room for more rows."""
    larger = np.zeros((len(array) + rows, *array.shape[1:]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger
