"""Automata that have left their place and lie inside cells of the grid, which they do not feel."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..grid.mesh import IntArray
from ..support.float_arrays import FloatArray

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
    tree: Any = cKDTree((0.25 * corners).sum(axis=1))
    sound = np.isfinite(points).all(axis=1)
    distances, near = (one.reshape(int(sound.sum()), -1) for one in tree.query(points[sound], k=min(_CELLS, len(cells))))
    # No cell is near what is so far off that the square of its distance overflows.
    near[np.isinf(distances)] = 0
    inside = np.ones(near.shape, dtype=bool)
    for corner in range(4):
        start, end = corners[near, corner], corners[near, (corner + 1) % 4]
        way, offset = end - start, points[sound][:, None] - start
        inside &= way[..., 0] * offset[..., 1] > way[..., 1] * offset[..., 0]
    return np.flatnonzero(sound)[inside.any(axis=1)]


def describe_strays(strays: IntArray, centres: FloatArray) -> list[str]:
    """Return a sentence about automata that lie inside cells, the first of them with its place; none where there are none."""
    if not len(strays):
        return []
    x, y = centres[strays[0]]
    return [
        f"{len(strays)} automata with broken links lie inside cells of the grid, automaton {strays[0]} at ({x:.6g}, "
        f"{y:.6g}) m: pieces touch automata alone, and fly through the free sides of the grid; set side_contacts = true, leave "
        "such sides no way to be reached, or surround the automata by the interface"
    ]
