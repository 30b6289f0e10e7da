"""Automata that have left their place and lie inside cells of the grid, which they do not feel."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..grid.mesh import IntArray
from ..support.arrays import FloatArray

# Cells whose centres are nearest to an automaton that are looked at.
_CELLS = 4


def find_strays(nodes: FloatArray, cells: IntArray, points: FloatArray) -> IntArray:
    """Return which points lie inside cells, in increasing order.

    Args:
        nodes: where they are now, shape (n, 2) [m].
        cells: the nodes of each cell, counterclockwise, convex, shape (m, 4).
        points: shape (k, 2) [m].
    """
    from scipy.spatial import cKDTree  # type: ignore[attr-defined]

    corners = nodes[cells]
    tree: Any = cKDTree(corners.mean(axis=1))
    sound = np.isfinite(points).all(axis=1)
    near = np.atleast_2d(tree.query(points[sound], k=min(_CELLS, len(cells)))[1].reshape(int(sound.sum()), -1))
    inside = np.ones(near.shape, dtype=bool)
    for corner in range(4):
        start, end = corners[near, corner], corners[near, (corner + 1) % 4]
        way, offset = end - start, points[sound][:, None] - start
        inside &= way[..., 0] * offset[..., 1] > way[..., 1] * offset[..., 0]
    return np.flatnonzero(sound)[inside.any(axis=1)]
