"""Search for the automata of a coupled body by position, and for the cell sides next to automata."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..automata.packing import Packing
from ..automata.shapes import ON_THE_OUTLINE, Shape
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray

# Distance from the middle of a side at which automata next to it are sought, as a fraction of the length of the side.
_PROBE = 0.01
# For each point this many cells, those with the nearest centres, are examined.
_CELLS = 4


class AutomatonSearch:
    """Search of automata by position, across periodic sides of the packing."""

    def __init__(self, packing: Packing, shape: Shape, origin: FloatArray, periodic: tuple[bool, bool]) -> None:
        """Build from the automata, their shape, the position of its origin [m], and the periodic axes."""
        from scipy.spatial import cKDTree  # type: ignore[attr-defined]

        self._tree: Any = cKDTree(packing.reference)
        self._origin, self._reach = origin, ON_THE_OUTLINE * packing.diameter
        left, right, low, high = shape.bounds
        self._begin, self._extent = np.array([left, low]), np.array([right - left, high - low])
        self._periodic = np.array(periodic)

    def nearest_automata(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the automata nearest to points, shape (k, 2) [m], and their distances, shape (k,) [m]."""
        inside = points - self._origin - self._begin
        turns = np.floor((inside + self._reach) / self._extent)
        inside = np.where(self._periodic, inside - turns * self._extent, inside)
        distance, automaton = self._tree.query(inside + self._begin)
        return automaton.astype(np.int64), distance

    def is_at_point(self, distance: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        """Return whether automata at these distances from a point [m] count as lying at the point."""
        return distance <= self._reach

    def are_within_period(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which points, shape (k, 2) [m], lie between the sides of the packing that a period joins."""
        inside = points - self._origin - self._begin
        return np.all(((inside >= 0.0) & (inside <= self._extent)) | ~self._periodic, axis=1)


def find_interface_sides(mesh: Mesh, shape: Shape, origin: FloatArray) -> IntArray:
    """Return the boundary sides of the grid with automata on their outer side, as node pairs, shape (k, 2)."""
    start, end = mesh.nodes[mesh.sides[:, 0]], mesh.nodes[mesh.sides[:, 1]]
    way = end - start
    # A side runs with the grid on its left, so automata are sought on its right.
    beside = 0.5 * (start + end) + _PROBE * np.stack([way[:, 1], -way[:, 0]], axis=1)
    return mesh.sides[shape.contains(beside - origin, 0.0)]


def points_in_cells(nodes: FloatArray, cells: IntArray, points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the points that lie inside cells, in increasing order, and one cell for each of them, both of shape (m,).

    Args:
        nodes: positions, shape (n, 2) [m].
        cells: the nodes of each cell, counterclockwise, convex, shape (c, 4).
        points: shape (k, 2) [m].
    """
    from scipy.spatial import cKDTree  # type: ignore[attr-defined]

    corners = nodes[cells]
    tree: Any = cKDTree((0.25 * corners).sum(axis=1))
    sound = np.flatnonzero(np.isfinite(points).all(axis=1))
    count = min(_CELLS, len(cells))
    distances, near = (one.reshape(len(sound), count) for one in tree.query(points[sound], k=count))
    # The search finds no cells if the square of the distance of a point overflows.
    near[np.isinf(distances)] = 0
    inside = np.ones(near.shape, dtype=bool)
    for corner in range(4):
        start, end = corners[near, corner], corners[near, (corner + 1) % 4]
        way, offset = end - start, points[sound][:, None] - start
        inside &= way[..., 0] * offset[..., 1] > way[..., 1] * offset[..., 0]
    found = inside.any(axis=1)
    return sound[found], near[found, inside[found].argmax(axis=1)]
