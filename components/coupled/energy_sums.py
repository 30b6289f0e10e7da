"""Energies and momenta of the coupled body, and the terms of the discrete energy of the leapfrog scheme."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.lattice import FORCE_X, FORCE_Y, INERTIA, MASS, SPIN, TORQUE, VX, VY, X, Y
from ..automata.loads import HOLDS_ROTATION, HOLDS_X, HOLDS_Y
from ..grid import kernels as grid_kernels
from ..support.float_arrays import FloatArray, ordered_sum
from .parts import AutomataPart, GridPart, Seam


class EnergySums(NamedTuple):
    """Energies [J] without links and contacts, momenta [N s], angular momenta [N m s], sums of force^2 / mass [N^2/kg].

    Attributes:
        kinetic: kinetic energy of the grid; interface nodes count with their mass from cells.
        hourglass: energy of the hourglass modes.
        pulled: sum of force^2 / mass over the nodes.
        elastic: stress work of the cells, without the plastic work.
        plastic: plastic work of the cells.
        automata_kinetic: kinetic energy of the automata; interface nodes count with the mass of the automata that they carry.
        rotational: energy of the rotations.
        automata_pulled: sum of force^2 / mass and torque^2 / inertia over the automata.
        momentum: of the coupled body, shape (2,).
        angular_momentum: of the coupled body, about the origin.
    """

    kinetic: float
    hourglass: float
    pulled: float
    elastic: float
    plastic: float
    automata_kinetic: float
    rotational: float
    automata_pulled: float
    momentum: FloatArray
    angular_momentum: float


def make_energy_sums(grid: GridPart, automata: AutomataPart, seam: Seam, own_mass: FloatArray, is_lockstep: bool) -> EnergySums:
    """Return the energy sums of a coupled body.

    Args:
        grid: the grid.
        automata: the automata.
        seam: the interface.
        own_mass: mass of each grid node from cells, without nodes joined to it and automata, shape (n,) [kg].
        is_lockstep: whether the forces on interface nodes are the sum of both sides, as in lockstep.
    """
    of_grid = np.zeros(6)
    grid_kernels.write_energy_sums(grid.grid, grid.state, own_mass, of_grid)
    state, conditions, interface = grid.state, grid.conditions, seam.interface
    share, mass, moves = conditions.share[:, None], conditions.mass[:, None], conditions.prescribed == 0
    force = state.force[conditions.nodes]
    pulled = ordered_sum(of_grid[2], np.where(moves, share * force * force / mass, 0.0))
    plastic = ordered_sum(state.plastic_work)

    # Here only free automata have linear momentum: interface automata move with their nodes, and only rotate freely.
    place, free = automata.body.layout.place, interface.free > 0
    cells, motion, forces = (
        automata.body.cells[:, place],
        automata.motion[:, place],
        automata.scratch.cells[: TORQUE + 1, place],
    )
    own, inertia, spin, torque = np.where(free, cells[MASS], 0.0), cells[INERTIA], motion[SPIN], forces[TORQUE]
    vx, vy, x, y = motion[VX], motion[VY], cells[X] + motion[X], cells[Y] + motion[Y]
    squares = (forces[FORCE_X] * forces[FORCE_X] + forces[FORCE_Y] * forces[FORCE_Y]) / cells[MASS]
    # Prescribed components do not respond to the force.
    grip, inertias = automata.edges.grip, np.stack([cells[MASS], cells[MASS], inertia])
    held = np.stack(
        [free[grip.automata] & (grip.held & bit > 0) for bit in (HOLDS_X, HOLDS_Y)] + [grip.held & HOLDS_ROTATION > 0]
    )
    resisted = np.where(held, -(forces * forces / inertias)[:, grip.automata], 0.0).T
    # The mass of the automata that the interface nodes carry.
    nodes, rows = interface.nodes, seam.exchange.places
    carried, (u, v) = interface.mass * conditions.share[rows], state.velocity[nodes].T
    at_x, at_y = (grid.grid.reference[nodes] + state.displacement[nodes]).T
    on_nodes = seam.exchange.automata_force
    yielding = np.where(moves[rows] & (not is_lockstep), share[rows] * on_nodes * on_nodes / mass[rows], 0.0)

    momentum = [ordered_sum(own * rate, carried * nodal) for rate, nodal in ((vx, u), (vy, v))]
    turning = ordered_sum(np.stack([inertia * spin, own * (x * vy - y * vx)], axis=1), carried * (at_x * v - at_y * u))
    return EnergySums(
        kinetic=float(of_grid[0]),
        hourglass=float(of_grid[1]),
        pulled=pulled,
        elastic=ordered_sum(state.energy) - plastic,
        plastic=plastic,
        automata_kinetic=ordered_sum(0.5 * own * (vx * vx + vy * vy), 0.5 * carried * (u * u + v * v)),
        rotational=ordered_sum(0.5 * inertia * spin * spin),
        automata_pulled=ordered_sum(np.stack([torque * torque / inertia, squares], axis=1), resisted, yielding),
        momentum=of_grid[3:5] + momentum,
        angular_momentum=float(of_grid[5] + turning),
    )


def leapfrog_energy(sums: EnergySums, step: float, micro_steps: int) -> float:
    """Return -h^2/8 times the sum of force^2 / mass, with the step size of each part [J]."""
    own = step / micro_steps
    return -0.125 * (step * step * sums.pulled + own * own * sums.automata_pulled)
