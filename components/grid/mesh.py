"""Meshes of quadrilaterals: nodes, cells, and the edges of the domain by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]
# A cell is refused as too flat if the triangle area at a corner is below this fraction of the square of its longest side.
_FLATTEST = 1e-6
# A node lies on a side if its distance is below this fraction of the side, and at a corner if its distance is below this
# fraction of the distance from the cell's centre to its farthest corner.
_ON_SIDE, _AT_CORNER = 1e-3, 5e-3


@dataclass(frozen=True)
class Mesh:
    """Nodes, cells, and the edges of the domain.

    Attributes:
        nodes: initial positions, shape (n, 2) [m].
        cells: the nodes of each cell, counterclockwise, shape (m, 4).
        edges: name -> cell sides on this part of the boundary, shape (k, 2): their two nodes, with the body on the left.
        orders: name -> nodes of an edge in the order of the parameters, shape (k,), only for edges given as lists of nodes.
    """

    nodes: FloatArray
    cells: IntArray
    edges: Mapping[str, IntArray] = field(default_factory=dict)
    orders: Mapping[str, IntArray] = field(default_factory=dict)

    @cached_property
    def areas(self) -> FloatArray:
        """Area of each cell, shape (m,) [m2]."""
        return cell_areas(self.nodes, self.cells)

    @cached_property
    def centres(self) -> FloatArray:
        """Mean of the four nodes of each cell, shape (m, 2) [m]."""
        corners = self.nodes[self.cells]
        return 0.25 * ((corners[:, 0] + corners[:, 2]) + (corners[:, 1] + corners[:, 3]))

    @cached_property
    def sides(self) -> IntArray:
        """The sides that belong to one cell only, shape (k, 2): their two nodes, with the body on the left."""
        sides = np.concatenate([self.cells[:, [j, (j + 1) % 4]] for j in range(4)])
        keys = np.sort(sides, axis=1)
        _, places, counts = np.unique(keys[:, 0] * len(self.nodes) + keys[:, 1], return_index=True, return_counts=True)
        return sides[np.sort(places[counts == 1])]

    def edge_nodes(self, name: str) -> IntArray:
        """Return the nodes of an edge in the given order, or sorted by x, then y, shape (k,)."""
        return self.orders[name] if name in self.orders else self.sorted_edge_nodes(name)

    def sorted_edge_nodes(self, name: str) -> IntArray:
        """Return the nodes of an edge sorted by x, then y, shape (k,)."""
        nodes = np.unique(self.edges[name])
        return nodes[np.lexsort((self.nodes[nodes, 1], self.nodes[nodes, 0]))]

    @cached_property
    def cell_radii(self) -> FloatArray:
        """Distance from the centre of each cell to its farthest corner, shape (m,) [m]."""
        return np.sqrt(((self.nodes[self.cells] - self.centres[:, np.newaxis]) ** 2).sum(axis=2).max(axis=1))

    def side_lengths(self, sides: IntArray) -> FloatArray:
        """Return the lengths of sides given by their two nodes, shape (k,) [m]."""
        x, y = (self.nodes[sides[:, 1]] - self.nodes[sides[:, 0]]).T
        return np.sqrt(x * x + y * y)

    def first_problem(self) -> tuple[str, str] | None:
        """Return the location and description of the first error in the mesh, or None."""
        n = len(self.nodes)
        outside = np.argwhere((self.cells < 0) | (self.cells >= n))
        if len(outside):
            cell, corner = outside[0]
            return f"cells[{cell}]", f"got node {self.cells[cell, corner]}, expected 0 to {n - 1}"
        ordered = np.sort(self.cells, axis=1)
        twice = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
        if len(twice):
            return f"cells[{twice[0]}]", f"got {self.cells[twice[0]].tolist()}, expected four different nodes"
        unused = np.flatnonzero(np.bincount(self.cells.ravel(), minlength=n) == 0)
        if len(unused):
            return f"nodes[{unused[0]}]", "does not belong to any cell; remove it, or renumber the nodes"
        return self._shape_problem() or self._side_problem() or self._find_unconnected_node()

    def _shape_problem(self) -> tuple[str, str] | None:
        """Return the error of the first cell with an inverted or flat corner, or None."""
        corners = self.nodes[self.cells]
        worst = np.full(len(self.cells), np.inf)
        longest = np.zeros(len(self.cells))
        for j in range(4):
            onward, back = corners[:, (j + 1) % 4] - corners[:, j], corners[:, (j + 3) % 4] - corners[:, j]
            worst = np.minimum(worst, 0.5 * (onward[:, 0] * back[:, 1] - onward[:, 1] * back[:, 0]))
            longest = np.maximum(longest, (onward * onward).sum(axis=1))
        bad = np.flatnonzero(~(worst > _FLATTEST * longest))
        if not len(bad):
            return None
        cell, area = int(bad[0]), float(self.areas[bad[0]])
        what = "inverted (its nodes run clockwise)" if area < 0.0 else "flat, crossed or not convex"
        return f"cells[{cell}]", (
            f"nodes {self.cells[cell].tolist()} form a cell of area {area:.6g} m2 that is {what}; expected four corners "
            "counterclockwise, each below 180 degrees"
        )

    def _side_problem(self) -> tuple[str, str] | None:
        """Return the error of a directed side that several cells share (cells are duplicated or overlap), or None."""
        sides = np.concatenate([self.cells[:, [j, (j + 1) % 4]] for j in range(4)])
        keys, counts = np.unique(sides[:, 0] * len(self.nodes) + sides[:, 1], return_counts=True)
        if counts.max() == 1:
            return None
        start, end = divmod(int(keys[np.argmax(counts)]), len(self.nodes))
        cells = np.unique(np.flatnonzero((sides == (start, end)).all(axis=1)) % len(self.cells)).tolist()
        return "cells", f"the cells {cells} lie on the same side of the line from node {start} to node {end}, expected only one"

    def _find_unconnected_node(self) -> tuple[str, str] | None:
        """Return the error of a node in a cell, or on its side, that is not its corner (overlap or no connection), or None."""
        from scipy.spatial import cKDTree  # type: ignore[attr-defined]

        corners, tree = self.nodes[self.cells], cKDTree(self.nodes)
        near: Any = tree.query_ball_point(self.centres, self.cell_radii)
        cell = np.repeat(np.arange(len(self.cells)), [len(one) for one in near])
        node = np.concatenate(near).astype(np.int64)
        foreign = np.ones(len(node), dtype=bool)
        for j in range(4):
            side, way = corners[cell, (j + 1) % 4] - corners[cell, j], self.nodes[node] - corners[cell, j]
            inside = side[:, 0] * way[:, 1] - side[:, 1] * way[:, 0]
            foreign &= inside > -_ON_SIDE * (side * side).sum(axis=1)
            # Exclude corners, and other nodes at the position of a corner, as on the opposite face of a slit.
            foreign &= (way * way).sum(axis=1) > (_AT_CORNER * self.cell_radii[cell]) ** 2
        if not foreign.any():
            return None
        first = int(np.argmax(foreign))
        return f"nodes[{node[first]}]", (
            f"lies in cell {cell[first]} or on a side of it, but is not its corner: cells overlap or are not connected; "
            "divide that cell, or for a slit give both faces nodes at the same positions or leave a gap between them"
        )


def cell_areas(nodes: FloatArray, cells: IntArray) -> FloatArray:
    """Return the area of each cell, negative if its nodes run clockwise, shape (m,) [m2]."""
    corners = nodes[cells]
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def rectangle_mesh(columns: int, rows: int, size: tuple[float, float], centre: tuple[float, float] | None) -> Mesh:
    """Return columns x rows equal cells; nodes and cells are numbered along x first.

    Coordinates are the centre plus multiples of the cell size: about a centre of 0, mirror images are bitwise exact.

    Args:
        columns: number of cells along x.
        rows: number of cells along y.
        size: width and height of a cell [m].
        centre: centre of the rectangle [m]; None puts the lower left corner at 0.
    """
    middle = (0.5 * columns * size[0], 0.5 * rows * size[1]) if centre is None else centre
    x, y = (middle[axis] + (np.arange(count + 1) - 0.5 * count) * size[axis] for axis, count in ((0, columns), (1, rows)))
    nodes: FloatArray = np.stack([np.tile(x, rows + 1), np.repeat(y, columns + 1)], axis=1).astype(np.float64)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    cells = np.stack([corner, corner + 1, corner + columns + 2, corner + columns + 1], axis=1)
    below, above = np.arange(columns), np.arange(columns) + rows * (columns + 1)
    left = np.arange(rows) * (columns + 1)
    edges = {
        "left": np.stack([left + columns + 1, left], axis=1),
        "right": np.stack([left + columns, left + 2 * columns + 1], axis=1),
        "bottom": np.stack([below, below + 1], axis=1),
        "top": np.stack([above + 1, above], axis=1),
    }
    return Mesh(nodes, cells, edges)


def mesh_without_cells(mesh: Mesh, is_removed: npt.NDArray[np.bool_]) -> Mesh:
    """Return a mesh without some of its cells, and without the nodes that no remaining cell uses."""
    cells = mesh.cells[~is_removed]
    used = np.zeros(len(mesh.nodes), dtype=bool)
    used[cells] = True
    number = np.cumsum(used) - 1
    left = Mesh(mesh.nodes[used], number[cells])
    # When cells are removed, an edge keeps those of its sides whose cell remains.
    there = {tuple(side) for side in left.sides.tolist()}
    edges: dict[str, Any] = {}
    for name, sides in mesh.edges.items():
        kept = number[sides[used[sides].all(axis=1)]]
        edges[name] = np.array([side for side in kept.tolist() if tuple(side) in there], dtype=np.int64).reshape(-1, 2)
    return Mesh(left.nodes, left.cells, edges)
