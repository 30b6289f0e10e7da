"""Tuples of arrays and numbers for kernels: integration points, nodes, hourglass control, surface, state, and scratch.

There are n nodes, m points, c columns (rows of nodes through the wall). The support of a point contains its neighbour nodes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..materials.thermoviscoplastic import FlowConstants
from ..support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]
IndexArray = npt.NDArray[np.uint32]
# Arrays of column numbers, -1 for none.
ColumnArray = npt.NDArray[np.int32]


class Points(NamedTuple):
    """The constant arrays of integration points.

    Attributes:
        begin: start of the neighbours of each point in `nodes`, and the end of the last one, shape (m + 1,).
        nodes: neighbours of the points, shape (entries,).
        kind: number of the stencil of each point, i.e. of its table of shape functions, shape (m,).
        first: start of each stencil in `gradients`, shape (stencils + 1,).
        gradients: gradients of the shape functions, along the axes at the point, shape (rows, 3) [1/m].
        along: factor by which gradients along the body are multiplied at each point, see `stencils`, shape (m,).
        volume: volume that each point represents, shape (m,) [m^3].
        sine, cosine: of the angle of these axes to those of the body, shape (m,).
    """

    begin: IndexArray
    nodes: IndexArray
    kind: IndexArray
    first: IndexArray
    gradients: FloatArray
    along: FloatArray
    volume: FloatArray
    sine: FloatArray
    cosine: FloatArray


class Nodes(NamedTuple):
    """The constant arrays of nodes.

    Attributes:
        mass: mass of each node, shape (n,) [kg].
        prescribed: 0 for a free velocity component, otherwise 1 + the first column of its signal, shape (n, 3).
        begin: where the points with each node in their support begin in `points`, and the end of the last ones, shape (n + 1,).
        points: points with the node in their supports, in ascending order for each node, shape (entries,).
        slot: index of the node among the neighbours of this point, shape (entries,).
    """

    mass: FloatArray
    prescribed: npt.NDArray[np.uint8]
    begin: IndexArray
    points: IndexArray
    slot: npt.NDArray[np.uint16]


class Hourglass(NamedTuple):
    """Springs between columns against modes that points at the columns do not resolve; see `hourglass`.

    Attributes:
        layers: number of nodes of a column.
        points: number of integration points of a column.
        shares: weight of each node in the mean displacement of its column, shape (n,).
        place: mean position of each column, shape (c, 3) [m].
        partner: columns tied to each column, -1 for none, shape (c, 4).
        stiffness: of these ties, shape (c, 4) [N/m].
        section: area that each tie represents; times the flow stress it is the largest force, shape (c, 4) [m^2].
    """

    layers: int
    points: int
    shares: FloatArray
    place: FloatArray
    partner: ColumnArray
    stiffness: FloatArray
    section: FloatArray


class Surface(NamedTuple):
    """The inner surface, on which the pressure acts: s nodes.

    Attributes:
        nodes: their numbers, shape (s,).
        station: number of the station (row of nodes around the body) of each, shape (s,).
        around: nodes of the surface before and after each one along the body and across it, itself if there is none,
            shape (s, 4).
        reference: initial positions, shape (s, 3) [m].
    """

    nodes: IntArray
    station: IntArray
    around: ColumnArray
    reference: FloatArray


class State(NamedTuple):
    """The state of the body, all arrays at the same tick.

    Attributes:
        displacement: coefficients of the shape functions (not values at nodes), shape (n, 3) [m].
        velocity: their time derivatives, shape (n, 3) [m/s].
        force: of stresses, hourglass control and wall on the nodes, shape (n, 3) [N].
        gradient: of the displacement, du_i/dX_j row by row, shape (m, 9).
        stress: Kirchhoff stress xx, yy, zz, xy, yz, zx, tension positive, shape (m, 6) [Pa].
        plastic_strain: equivalent plastic strain, shape (m,); (0,) for an elastic material, like the next two arrays.
        temperature: shape (m,) [K].
        plastic_work: plastic work per initial volume, shape (m,) [J/m^3].
        area: vector area of the inner surface at each of its nodes, normal into the body, shape (s, 3) [m^2].
    """

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    gradient: FloatArray
    stress: FloatArray
    plastic_strain: FloatArray
    temperature: FloatArray
    plastic_work: FloatArray
    area: FloatArray


class Scratch(NamedTuple):
    """Scratch memory; its contents are not kept between ticks.

    Attributes:
        pull: nominal stress times volume of each point, along its own axes, shape (m, 9) [N m].
        column_force: force of the hourglass control on each column, shape (c, 3) [N].
        tie_energy: half of the energy of each tie of the columns, shape (c, 4) [J].
        before: velocity of the nodes of the inner surface at the beginning of the tick, shape (s, 3) [m/s].
        area: vector area of the inner surface at these nodes at the end of the tick, shape (s, 3) [m^2].
    """

    pull: FloatArray
    column_force: FloatArray
    tie_energy: FloatArray
    before: FloatArray
    area: FloatArray


class Solid(NamedTuple):
    """The constant tables.

    Attributes:
        points: the integration points.
        nodes: the nodes.
        hourglass: the hourglass control.
        surface: the inner surface.
        law: constants of the material.
        plastic: whether the material can yield.
        step: length of a tick [s].
        wall: x of a rigid wall, and 1 for a body above it, -1 for one below, 0 without a wall, shape (2,).
        bounce: stiffness of the contact of each node with the wall, shape (n,) [N/m]; (0,) without a wall.
        reference: initial positions of the nodes, shape (n, 3) [m].
    """

    points: Points
    nodes: Nodes
    hourglass: Hourglass
    surface: Surface
    law: FlowConstants
    plastic: bool
    step: float
    wall: FloatArray
    bounce: FloatArray
    reference: FloatArray


class Tables(NamedTuple):
    """All arguments of a tick; `tally` has the entries named below, shape (TALLY,)."""

    solid: Solid
    state: State
    scratch: Scratch
    tally: FloatArray


# Entries of the tally (sums since the reset); vectors have three entries. WALL_FORCE is not a sum but the present force.
PRESSURE_WORK, BOUNDARY_WORK, PRESSURE_IMPULSE, BOUNDARY_IMPULSE, WALL_IMPULSE, WALL_FORCE, TALLY = 0, 1, 2, 5, 8, 9, 10
# Statuses of a tick: a point is inverted, strained too much in one tick, or beyond the limits of plastic strain or temperature.
INVERTED, STRAINED, FLOWN, HEATED = 1, 2, 3, 4


def make_scratch(points: int, columns: int, surface: int) -> Scratch:
    """Return scratch for given numbers of integration points, columns and nodes of the inner surface."""
    return Scratch(
        np.zeros((points, 9)), np.zeros((columns, 3)), np.zeros((columns, 4)), np.zeros((surface, 3)), np.zeros((surface, 3))
    )


def support_entries(points: Any, numbers: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return for each neighbour of each point: the index of the point in `numbers`, the node, the row of its shape function.

    Args:
        points: `Points`, or the `Stencils` of points.
        numbers: numbers of the points, shape (k,).
    """
    begin = points.begin[numbers].astype(np.int64)
    counts = points.begin[numbers + 1] - begin
    owner = np.repeat(np.arange(len(numbers)), counts)
    slot = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, points.nodes[begin[owner] + slot], points.first[points.kind[numbers]].astype(np.int64)[owner] + slot
