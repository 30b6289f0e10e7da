"""Tuples of arrays for kernels: the mesh, the state, the nodes with conditions, scratch.

n nodes, m cells. A corner force is the force of one cell on one of its nodes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IndexArray = npt.NDArray[np.uint32]
Int32Array = npt.NDArray[np.int32]


class Grid(NamedTuple):
    """The constant arrays of a grid: mesh, masses, materials.

    Attributes:
        reference: initial positions of the nodes, shape (n, 2) [m].
        cells: nodes of each cell, counterclockwise, shape (m, 4).
        mass: mass that moves with each node, shape (n,) [kg]; for joined nodes the mass of the whole group.
        half_inverse: 1 / (2 mass), shape (n,) [1/kg].
        material: number of the material of each cell, shape (m,).
        moduli: Lame's constants of each material, shape (materials, 2) [Pa].
        laws: plastic laws of the materials, see `yielding.law_list`.
        hourglass: stiffness of each cell against its two hourglass modes, shape (m,) [Pa].
        node_slots: rows of the corner forces on a node, one per local corner number of a cell, shape (n, 4).
        further: node and row of each corner force that has no place in `node_slots`, shape (k, 2).
        special: 1 for nodes in `Conditions`, which are moved separately, shape (n,).
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
    """The state of a grid, all arrays at the same tick.

    Attributes:
        displacement: of the nodes from `reference`, shape (n, 2) [m].
        velocity: shape (n, 2) [m/s].
        force: of the cells on the nodes, shape (n, 2) [N].
        stress: xx, yy, zz, xy of the cells, tension positive, shape (m, 4) [Pa].
        hourglass_force: force amplitude of the two hourglass modes of each cell, shape (m, 2) [N].
        energy: work of the stresses in each cell, and of hourglass forces during plastic flow, shape (m,) [J].
        plastic_strain: equivalent, shape (m,); (0,) if no material can yield.
        plastic_work: shape (m,) [J]; (0,) if no material can yield.
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
    """The s nodes with conditions: loads, dashpots, prescribed velocities, periodic joints, or masses of another body.

    Attributes:
        nodes: their numbers, shape (s,).
        mass: mass that moves with each node, shape (s,) [kg].
        damping: coefficients xx, yy, xy of the dashpots, shape (s, 3) [N s/m].
        prescribed: 1 for a component whose velocity is given, shape (s, 2).
        share: fraction of a joined group that this node represents in sums, shape (s,).
        groups: two or four nodes that move together, rows padded with -1, shape (k, 4).
        drive: force [N], or prescribed velocity [m/s], for each signal (a factor that depends on time), shape (signals, s, 2).
        begin: scratch: velocity and force at the beginning of the tick, applied force, dashpot force, mid-step velocity,
            shape (s, 5, 2).
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
    """All arguments of the kernels; `corner` is scratch for corner forces, shape (4 m + 1, 2) [N], and its last row is 0."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray


class Yields(NamedTuple):
    """Events of cells that yield for the first time: rows, shape (capacity, 5), and the number of rows in use, shape (1,)."""

    rows: FloatArray
    used: npt.NDArray[np.int64]


# Entries of the tally: energy, impulse and angular impulse that the conditions have supplied or absorbed since the reset.
WORK, ABSORBED, IMPULSE, BOUNDARY_IMPULSE, ANGULAR, BOUNDARY_ANGULAR, TALLY = 0, 1, 2, 4, 6, 7, 8
