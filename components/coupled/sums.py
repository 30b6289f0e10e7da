"""Energies and momenta of the whole, and what the energy of the leapfrog scheme needs."""

from __future__ import annotations

from ..automata.loads import HOLDS_ROTATION, HOLDS_X, HOLDS_Y
from ..grid import kernels as grid_kernels
from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit

# Entries of the sums: of the grid, then of the automata.
KINETIC, HOURGLASS, PULLED, MOMENTUM, ANGULAR_MOMENTUM = 0, 1, 2, 3, 5
AUTOMATA_KINETIC, ROTATIONAL, AUTOMATA_PULLED, AUTOMATA_MOMENTUM, AUTOMATA_ANGULAR_MOMENTUM = 6, 7, 8, 9, 11
ELASTIC, PLASTIC, SUMS = 12, 13, 14


@jit
def write_sums(grid, automata, seam, own_mass, together, sums_out):
    """Write energies [J], momenta [N s], their moments [N m s], and force^2 / mass of each part, shape (SUMS,).

    Without the energies of links and contacts. ELASTIC is the work of the stresses of the cells, PLASTIC included.

    Args:
        grid: a `GridPart`.
        automata: an `AutomataPart`.
        seam: a `Seam`.
        own_mass: of each node of the grid, without joined nodes and automata, shape (n,) [kg].
        together: whether the forces on interface nodes are those of both sides, as in lockstep.
        sums_out: written. Of the mass of interface nodes each part has its own.
    """
    sums_out[:] = 0.0
    grid_kernels.energies(grid.grid, grid.state, own_mass, sums_out)
    for i in range(len(grid.conditions.nodes)):
        for k in range(2):
            if not grid.conditions.prescribed[i, k]:
                force = grid.state.force[grid.conditions.nodes[i], k]
                sums_out[PULLED] += grid.conditions.share[i] * force * force / grid.conditions.mass[i]
    for c in range(len(grid.state.energy)):
        sums_out[ELASTIC] += grid.state.energy[c]
    for c in range(len(grid.state.plastic_work)):
        sums_out[PLASTIC] += grid.state.plastic_work[c]
    add_automata(automata, seam.interface, sums_out)
    leave_out_held(automata, seam.interface, sums_out)
    add_carried(grid, seam, together, sums_out)


@internal
def add_automata(automata, interface, sums_out):
    """Add the automata; of those of the interface the rotation alone."""
    body, motion, forces = automata.body, automata.motion, automata.scratch.forces
    for i in range(body.layout.place.size):
        p = body.layout.place[i]
        mass, inertia, w, torque = body.mass[p], body.inertia[p], motion.spin[p], forces.torque[p]
        sums_out[ROTATIONAL] += 0.5 * inertia * w * w
        sums_out[AUTOMATA_PULLED] += torque * torque / inertia
        sums_out[AUTOMATA_ANGULAR_MOMENTUM] += inertia * w
        if interface.free[i]:
            vx, vy, fx, fy = motion.vx[p], motion.vy[p], forces.x[p], forces.y[p]
            sums_out[AUTOMATA_KINETIC] += 0.5 * mass * (vx * vx + vy * vy)
            sums_out[AUTOMATA_PULLED] += (fx * fx + fy * fy) / mass
            sums_out[AUTOMATA_MOMENTUM] += mass * vx
            sums_out[AUTOMATA_MOMENTUM + 1] += mass * vy
            sums_out[AUTOMATA_ANGULAR_MOMENTUM] += mass * ((body.x[p] + motion.x[p]) * vy - (body.y[p] + motion.y[p]) * vx)


@internal
def leave_out_held(automata, interface, sums_out):
    """Take away force^2 / mass of what is held: it does not move with the force."""
    body, grip, forces = automata.body, automata.edges.grip, automata.scratch.forces
    for row in range(grip.automata.size):
        p, held, free = grip.place[row], grip.held[row], interface.free[grip.automata[row]]
        if held & HOLDS_X and free:
            sums_out[AUTOMATA_PULLED] -= forces.x[p] * forces.x[p] / body.mass[p]
        if held & HOLDS_Y and free:
            sums_out[AUTOMATA_PULLED] -= forces.y[p] * forces.y[p] / body.mass[p]
        if held & HOLDS_ROTATION:
            sums_out[AUTOMATA_PULLED] -= forces.torque[p] * forces.torque[p] / body.inertia[p]


@internal
def add_carried(grid, seam, together, sums_out):
    """Add the mass of automata that moves with interface nodes."""
    state, conditions, interface = grid.state, grid.conditions, seam.interface
    for row in range(interface.nodes.size):
        n, i = interface.nodes[row], seam.exchange.places[row]
        share = conditions.share[i]
        mass = interface.mass[row] * share
        vx, vy = state.velocity[n, 0], state.velocity[n, 1]
        x, y = grid.grid.reference[n, 0] + state.displacement[n, 0], grid.grid.reference[n, 1] + state.displacement[n, 1]
        sums_out[AUTOMATA_KINETIC] += 0.5 * mass * (vx * vx + vy * vy)
        sums_out[AUTOMATA_MOMENTUM] += mass * vx
        sums_out[AUTOMATA_MOMENTUM + 1] += mass * vy
        sums_out[AUTOMATA_ANGULAR_MOMENTUM] += mass * (x * vy - y * vx)
        for k in range(2):
            if not together and not conditions.prescribed[i, k]:
                force = seam.exchange.automata_force[row, k]
                sums_out[AUTOMATA_PULLED] += share * force * force / conditions.mass[i]


def grid_elastic(found: FloatArray) -> float:
    """Return the elastic energy of the cells: what their stresses have done, less what has become plastic [J]."""
    return float(found[ELASTIC]) - float(found[PLASTIC])


def momentum(found: FloatArray) -> FloatArray:
    """Return the momentum of the whole, shape (2,) [N s]."""
    return found[MOMENTUM : MOMENTUM + 2] + found[AUTOMATA_MOMENTUM : AUTOMATA_MOMENTUM + 2]


def angular_momentum(found: FloatArray) -> float:
    """Return the angular momentum of the whole about the origin [N m s]."""
    return float(found[ANGULAR_MOMENTUM] + found[AUTOMATA_ANGULAR_MOMENTUM])


def leapfrog(found: FloatArray, step: float, micro: int) -> float:
    """Return -h^2/8 times the sum of force^2 / mass, each part with its own step [J]."""
    own = step / micro
    return -0.125 * float(step * step * found[PULLED] + own * own * found[AUTOMATA_PULLED])
