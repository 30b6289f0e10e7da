"""Tuples of plain arrays for kernels: the mesh, the state, the nodes with conditions, scratch.

n nodes, m cells. A corner force is that of one cell on one of its nodes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IndexArray = npt.NDArray[np.uint32]
Int32Array = npt.NDArray[np.int32]


class Grid(NamedTuple):
    """The constant arrays: mesh, masses, materials.

    Attributes:
        reference: nodes before anything moves, shape (n, 2) [m].
        cells: nodes of each cell, counterclockwise, shape (m, 4).
        mass: what moves with a node, shape (n,) [kg]; of joined nodes that of all of them.
        half_inverse: 1 / (2 mass), shape (n,) [1/kg].
        material: number of each cell's material, shape (m,).
        moduli: Lame's constants of each material, shape (materials, 2) [Pa].
        laws: plastic laws of the materials, see `yielding.law_list`.
        hourglass: stiffness of each cell against its two hourglass modes, shape (m,) [Pa].
        node_slots: rows of the corner forces on a node, one for each corner that a cell can turn to it, shape (n, 4).
        further: corner forces beyond these, (node, row), shape (k, 2).
        special: 1 for nodes that are not moved with the others but in `Conditions`, shape (n,).
    """

    reference: FloatArray
    cells: IndexArray
    mass: FloatArray
    half_inverse: FloatArray
    material: IndexArray
    moduli: FloatArray
    laws: Any
    hourglass: FloatArray
    node_slots: IndexArray
    further: IndexArray
    special: npt.NDArray[np.uint8]


class State(NamedTuple):
    """The changing arrays; all of one tick.

    Attributes:
        displacement: of the nodes from `reference`, shape (n, 2) [m].
        velocity: shape (n, 2) [m/s].
        force: of the cells on the nodes, shape (n, 2) [N].
        stress: xx, yy, zz, xy of the cells, tension positive, shape (m, 4) [Pa].
        hourglass_force: shape (m, 2) [N].
        energy: work that stresses, and hourglass forces as they flow, have done on the cells, shape (m,) [J].
        plastic_strain: equivalent, shape (m,); (0,) where no material can yield.
        plastic_work: shape (m,) [J]; (0,) where no material can yield.
    """

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    stress: FloatArray
    hourglass_force: FloatArray
    energy: FloatArray
    plastic_strain: FloatArray
    plastic_work: FloatArray


class Conditions(NamedTuple):
    """Nodes that feel more than their cells, s of them, each moved on its own.

    Attributes:
        nodes: their numbers, shape (s,).
        mass: shape (s,) [kg].
        damping: dashpots xx, yy, xy, shape (s, 3) [N s/m].
        prescribed: 1 where a component of the velocity is given, shape (s, 2).
        share: of a joined group that this node stands for, in sums, shape (s,).
        groups: nodes that move as one, two or four, the rest -1, shape (k, 4).
        drive: forces [N], or velocities [m/s] where prescribed, for each signal, shape (signals, s, 2).
        begin: scratch: velocity and force at the tick's begin, applied force, dashpot force, velocity of the middle of the
            tick, shape (s, 5, 2).
    """

    nodes: IndexArray
    mass: FloatArray
    damping: FloatArray
    prescribed: npt.NDArray[np.uint8]
    share: FloatArray
    groups: Int32Array
    drive: FloatArray
    begin: FloatArray


class Tables(NamedTuple):
    """All that the kernels work on; `corner` is scratch for the corner forces, shape (4 m + 1, 2), its last row 0 [N]."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray


class Yields(NamedTuple):
    """The events of cells that yield for the first time: rows, shape (capacity, 5), and how many are in use, shape (1,)."""

    rows: FloatArray
    used: npt.NDArray[np.int64]


# Entries of the tally: what came in, or went out, through the conditions since the reset.
WORK, ABSORBED, IMPULSE, BOUNDARY_IMPULSE, ANGULAR, BOUNDARY_ANGULAR, TALLY = 0, 1, 2, 4, 6, 7, 8
