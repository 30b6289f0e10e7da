"""Boundaries of the body, by name: clamped, symmetry, moved, platen, wall; an edge that is not named is free.

The module also computes the signals of their inputs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ..inputs import Held
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray
from .geometry.bodies import EDGES, Tube
from .geometry.lattice import Lattice
from .kernel_arrays import IntArray

EdgeName = Literal["start", "end", "left", "right", "bottom", "top"]
BoundaryName = Literal["clamped", "symmetry", "moved", "platen", "wall"]
# Value of `Nodes.prescribed` for a component at rest; smaller values refer to columns of the signals (velocities by inputs).
AT_REST = 255


class Conditions(NamedTuple):
    """The prescribed velocities.

    Attributes:
        prescribed: which velocity components are prescribed, see `kernel_arrays.Nodes`, shape (n, 3).
        moved: edges whose velocity is an input, in the order of their columns in the signals, three per edge from column 1 on;
            with the axis of a platen, which moves only along that axis, or -1 for an edge that moves in all directions.
        wall: position and side of a rigid wall, see `kernel_arrays.Solid`, shape (2,).
    """

    prescribed: npt.NDArray[np.uint8]
    moved: dict[str, int]
    wall: npt.NDArray[np.float64]


def edge_nodes(lattice: Lattice, edge: str) -> IntArray:
    """Return the nodes of an edge, ascending, without nodes at the bottom of a notch."""
    axis, end = EDGES[edge]
    numbers = np.arange(lattice.node_count).reshape(lattice.shape)
    nodes = np.take(numbers, end, axis=axis).ravel()
    return nodes[lattice.indices(nodes)[:, axis] == end % lattice.shape[axis]]


def make_conditions(body: object, lattice: Lattice, boundaries: dict[EdgeName, BoundaryName]) -> Conditions:
    """Return the velocities prescribed by the boundaries; where edges meet, the later one in the order of `EDGES` applies."""
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


def tick_signals(inputs: Mapping[str, Held], moved_edges: Mapping[str, int], tick: int, ticks: int) -> FloatArray:
    """Return the mean pressure factor and the mean velocities of moved edges over each of `ticks` ticks from `tick` on.

    Returns:
        Shape (ticks, 1 + 3 edges).
    """
    signals = np.ones((ticks, 1 + 3 * len(moved_edges)))
    if isinstance(inputs["pressure"], CompiledProfile):
        signals[:, 0] = inputs["pressure"].mean_factors(tick, ticks)
    for place, (edge, axis) in enumerate(moved_edges.items()):
        velocity = inputs[f"{edge}_velocity"]
        columns = slice(1 + 3 * place, 4 + 3 * place) if axis < 0 else slice(1 + 3 * place + axis, 2 + 3 * place + axis)
        signals[:, columns] = signal_pattern(velocity)
        if isinstance(velocity, CompiledProfile):
            signals[:, columns] *= velocity.mean_factors(tick, ticks)[:, None]
    return signals


def signal_pattern(value: Held) -> FloatArray:
    """Return a copy of the array that the profile of an input multiplies; for an input without profile, of its value.

    The copy is always writable. Held arrays are read-only and arrays of some profiles are not: numba would compile twice.
    """
    pattern = value.pattern if isinstance(value, CompiledProfile) else value
    return np.array(1.0 if pattern is None else pattern, dtype=np.float64)
