"""Boundaries of the body, by name: clamped, symmetry, moved, platen, wall; an edge that is not named is free."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from .geometry.bodies import EDGES, Tube
from .geometry.lattice import Lattice
from .kernel_arrays import IntArray

EdgeName = Literal["start", "end", "left", "right", "bottom", "top"]
BoundaryName = Literal["clamped", "symmetry", "moved", "platen", "wall"]
# Of `kernel_arrays.Body.prescribed`: at rest; smaller numbers are columns of the signals.
AT_REST = 255


class Conditions(NamedTuple):
    """The velocities that are prescribed.

    Attributes:
        prescribed: see `kernel_arrays.Body`, shape (n, 3).
        moved: edges whose velocity is an input, in the order of their columns of the signals, three each from column 1 on;
            with the axis of a platen, which moves along that alone, and -1 for such as move in all directions.
        wall: see `kernel_arrays.Solid`, shape (2,).
    """

    prescribed: npt.NDArray[np.uint8]
    moved: dict[str, int]
    wall: npt.NDArray[np.float64]


def edge_nodes(lattice: Lattice, edge: str) -> IntArray:
    """Return the nodes of an edge, ascending; the bottom of a notch in it is none of it."""
    axis, end = EDGES[edge]
    numbers = np.arange(lattice.node_count).reshape(lattice.shape)
    nodes = np.take(numbers, end, axis=axis).ravel()
    return nodes[lattice.places(nodes)[:, axis] == end % lattice.shape[axis]]


def make_conditions(body: object, lattice: Lattice, boundaries: dict[EdgeName, BoundaryName]) -> Conditions:
    """Return what the boundaries prescribe; where edges meet, the later of the order of `EDGES` decides."""
    prescribed = np.zeros((lattice.node_count, 3), dtype=np.uint8)
    kinds = {edge: boundaries.get(edge) for edge in EDGES}  # type: ignore[call-overload]
    axes = {edge: axis for edge, (axis, _) in EDGES.items()}
    moved = {edge: -1 if kind == "moved" else axes[edge] for edge, kind in kinds.items() if kind in ("moved", "platen")}
    wall = np.zeros(2)
    if isinstance(body, Tube) and body.half:
        for edge in ("left", "right"):
            prescribed[edge_nodes(lattice, edge), 1] = AT_REST
    for edge, (axis, end) in EDGES.items():
        nodes, kind = edge_nodes(lattice, edge), kinds[edge]
        if kind == "clamped":
            prescribed[nodes] = AT_REST
        elif kind == "symmetry":
            prescribed[nodes, axis] = AT_REST
        elif kind == "moved":
            prescribed[nodes] = 1 + 3 * list(moved).index(edge) + np.arange(3)
        elif kind == "platen":
            prescribed[nodes, axis] = 1 + 3 * list(moved).index(edge) + axis
        elif kind == "wall":
            wall[:] = lattice.nodes[nodes[0], 0], 1.0 if end == 0 else -1.0
    return Conditions(prescribed, moved, wall)
