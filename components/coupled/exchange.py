"""The exchange between grid and automata at their interface: forces, and the work and impulse of each side on the other.

At an interface node with the masses m_g and m_a and the forces F_g and F_a of the two sides, the sides exchange the impulses

    J_g = m_g (v1 - v0) - time F_g,        J_a = m_a (v1 - v0) - time F_a,        J_g + J_a = 0.

The work of an impulse is the impulse times the mean velocity. It is summed for each side; the difference measures the coupling.
"""

from __future__ import annotations

from typing import NamedTuple

from ..automata.lattice import FORCE_X, FORCE_Y, VX, VY, X, Y, update_ghost_velocities, update_ghosts
from ..grid.mesh import IntArray
from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit

# Entries of the tally: work on the grid, work on the automata, impulse on the automata along x and y; since the reset.
WORK_ON_GRID, WORK_ON_AUTOMATA, IMPULSE, EXCHANGE_TALLY = 0, 1, 2, 4


class Exchange(NamedTuple):
    """Forces on interface nodes, scratch arrays and the tally.

    Attributes:
        places: row of each interface node in the `Conditions` of the grid, shape (s,).
        grid_force: of cells on the nodes, joined nodes included, part of the state, shape (s, 2) [N].
        automata_force: of automata on the nodes, part of the state, shape (s, 2) [N].
        before: scratch: velocities before a kick, shape (s, 2) [m/s].
        start: scratch: displacements at the beginning of a tick, shape (s, 2) [m].
        given: scratch: impulse of automata on prescribed components in a tick, shape (s, 2) [N s].
        tally: work and impulse of the exchange since the reset, see EXCHANGE_TALLY.
    """

    places: IntArray
    grid_force: FloatArray
    automata_force: FloatArray
    before: FloatArray
    start: FloatArray
    given: FloatArray
    tally: FloatArray


@internal
def gather_forces(interface, place, forces, out):
    """Write the force of the automata on each interface node, shape (s, 2) [N]; `place` are their indices in `forces`."""
    for row in range(interface.nodes.size):
        fx = fy = 0.0
        for acting in range(interface.first[row], interface.first[row + 1]):
            p, share = place[interface.automata[interface.acting[acting]]], interface.shares[acting]
            fx += share * forces[FORCE_X, p]
            fy += share * forces[FORCE_Y, p]
        out[row, 0], out[row, 1] = fx, fy


@internal
def interpolate_to_automata(interface, place, nodal_values, x, y):
    """Interpolate nodal values, shape (nodes, 2), to the interface automata; write their components to the fields x and y."""
    for row in range(interface.automata.size):
        p, a, b = place[interface.automata[row]], interface.ends[row, 0], interface.ends[row, 1]
        first, second = interface.weights[row, 0], interface.weights[row, 1]
        x[p] = first * nodal_values[a, 0] + second * nodal_values[b, 0]
        y[p] = first * nodal_values[a, 1] + second * nodal_values[b, 1]


@internal
def move_interface_automata(interface, layout, displacement, velocity, motion):
    """Give the interface automata the displacements and velocities interpolated from their nodes."""
    interpolate_to_automata(interface, layout.place, displacement, motion[X], motion[Y])
    update_ghosts(layout.ghosts, motion[X])
    update_ghosts(layout.ghosts, motion[Y])
    set_interface_velocities(interface, layout, velocity, motion)


@internal
def set_interface_velocities(interface, layout, velocity, motion):
    """Give the interface automata the velocities of their nodes, without moving them."""
    interpolate_to_automata(interface, layout.place, velocity, motion[VX], motion[VY])
    update_ghost_velocities(layout.ghosts, motion)


@internal_inlined
def kicked_velocity(velocity, time, grid_force, automata_force, grid_mass, automata_mass, by_momentum):
    """Return the velocity of an interface node after a kick of `time` [s].

    By force: equation (18) of Psakhie et al., with physical forces. By momentum: each side alone, then m V = m_a V_a + m_c V_c.
    """
    if by_momentum and automata_mass > 0.0:
        of_grid = velocity + time * grid_force / grid_mass
        of_automata = velocity + time * automata_force / automata_mass
        return (automata_mass * of_automata + grid_mass * of_grid) / (automata_mass + grid_mass)
    return velocity + time * (grid_force + automata_force) / (grid_mass + automata_mass)


@jit
def assemble_interface_forces(seam, state, conditions, time, by_momentum):
    """Write the total forces on interface nodes that give them the velocity `kicked_velocity` after a kick of `time` [s]."""
    interface, exchange = seam.interface, seam.exchange
    for row in range(interface.nodes.size):
        n, i = interface.nodes[row], exchange.places[row]
        mass, carried = conditions.mass[i], interface.mass[row]
        for k in range(2):
            of_cells, of_automata = exchange.grid_force[row, k], exchange.automata_force[row, k]
            if by_momentum:
                now = state.velocity[n, k]
                state.force[n, k] = (
                    mass
                    * (kicked_velocity(now, time, of_cells, of_automata, mass - carried, carried, by_momentum) - now)
                    / time
                )
            else:
                state.force[n, k] = of_cells + of_automata


@internal
def copy_interface_rows(nodes, values, out):
    """Copy the rows of the interface nodes from a nodal array, shape (n, 2), to an array of shape (s, 2)."""
    for row in range(nodes.size):
        out[row, 0], out[row, 1] = values[nodes[row], 0], values[nodes[row], 1]


@internal
def tally_kick(seam, velocity, conditions, grid_time, automata_time):
    """Tally work and impulse of each side on the other in a kick; `exchange.before` holds the velocities before the kick.

    Args:
        seam: a `parts.Seam`; the tally of its exchange is updated.
        velocity: of the grid nodes after the kick, shape (n, 2) [m/s].
        conditions: of the grid; the forces that they apply count as forces of the grid.
        grid_time: duration for which the forces of the grid acted [s].
        automata_time: duration for which the forces of the automata acted [s].
    """
    interface, exchange = seam.interface, seam.exchange
    for row in range(interface.nodes.size):
        n, i, carried = interface.nodes[row], exchange.places[row], interface.mass[row]
        share = conditions.share[i]
        for k in range(2):
            if conditions.prescribed[i, k]:
                continue
            before, after = exchange.before[row, k], velocity[n, k]
            outer = exchange.grid_force[row, k] + (conditions.begin[i, 2, k] + conditions.begin[i, 3, k])
            on_grid = (conditions.mass[i] - carried) * (after - before) - grid_time * outer
            on_automata = carried * (after - before) - automata_time * exchange.automata_force[row, k]
            mean = 0.5 * (before + after)
            exchange.tally[WORK_ON_GRID] += share * (on_grid * mean)
            exchange.tally[WORK_ON_AUTOMATA] += share * (on_automata * mean)
            exchange.tally[IMPULSE + k] += share * on_automata
