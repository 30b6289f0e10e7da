"""Automata of a coupled body by their place, and the sides of cells that they lie beside."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt

from ..automata.packing import Packing
from ..automata.shapes import ON_THE_OUTLINE, Shape
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray

# How far beside the middle of a side it is looked for automata, in lengths of the side.
_PROBE = 0.01


class Places:
    """Automata by their place, across the sides where a packing is closed on itself."""

    def __init__(self, packing: Packing, shape: Shape, origin: FloatArray, periodic: tuple[bool, bool]) -> None:
        """Take the automata, what they fill, where its origin lies [m], and along which axes it is closed on itself."""
        from scipy.spatial import cKDTree  # type: ignore[attr-defined]

        self._tree: Any = cKDTree(packing.reference)
        self._centres, self._origin, self._reach = packing.reference, origin, ON_THE_OUTLINE * packing.diameter
        left, right, low, high = shape.bounds
        self._begin, self._extent = np.array([left, low]), np.array([right - left, high - low])
        self._periodic = np.array(periodic)

    def find(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the automata nearest to points, shape (k, 2) [m], and how far off they are, shape (k,) [m]."""
        inside = points - self._origin - self._begin
        turns = np.floor((inside + self._reach) / self._extent)
        inside = np.where(self._periodic, inside - turns * self._extent, inside)
        distance, automaton = self._tree.query(inside + self._begin)
        return automaton.astype(np.int64), distance

    def is_at(self, distance: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        """Return whether automata so far off a point [m] stand on it."""
        return distance <= self._reach

    def may_be_near(self, points: FloatArray, radii: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which points, shape (k, 2) [m], lie within radii, shape (k,) [m], of the rectangle around the automata."""
        inside, reach = points - self._origin - self._begin, radii[:, np.newaxis]
        return np.all((inside >= -reach) & (inside <= self._extent + reach), axis=1)

    def near(self, points: FloatArray, radii: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the automata within a radius of each point: number of the point, automaton, and its centre [m].

        An automaton on the left or lower side of two that are one stands on the opposite side too.

        Args:
            points: shape (k, 2) [m].
            radii: shape (k,) [m].
        """
        found: list[tuple[Any, ...]] = []
        for turn in itertools.product(*((0, 1) if closed else (0,) for closed in self._periodic)):
            moved = self._origin + turn * self._extent
            near = self._tree.query_ball_point(points - moved, radii)
            point = np.repeat(np.arange(len(points)), [len(one) for one in near])
            automaton = np.fromiter(itertools.chain.from_iterable(near), np.int64, len(point))
            found.append((point, automaton, self._centres[automaton] + moved))
        point, automaton, centre = (np.concatenate(one) for one in zip(*found, strict=True))
        return point, automaton, centre

    def are_within_period(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which points, shape (k, 2) [m], lie between the sides where the packing is closed on itself."""
        inside = points - self._origin - self._begin
        return np.all(((inside >= 0.0) & (inside <= self._extent)) | ~self._periodic, axis=1)


def common_sides(mesh: Mesh, shape: Shape, origin: FloatArray) -> IntArray:
    """Return the sides of the boundary of the grid that have automata on their other side, shape (k, 2): the nodes of each."""
    start, end = mesh.nodes[mesh.sides[:, 0]], mesh.nodes[mesh.sides[:, 1]]
    way = end - start
    # The body is on the left.
    beside = 0.5 * (start + end) + _PROBE * np.stack([way[:, 1], -way[:, 0]], axis=1)
    return mesh.sides[shape.contains(beside - origin, 0.0)]
