"""The first forces of a coupled medium, which its first tick begins with."""

from __future__ import annotations

from ..automata.cracking_steps import add_forces
from ..support.jit import jit
from .exchange import assemble, follow, gather_forces, keep_grid_forces
from .side_contacts import add_side_forces


@jit
def follow_nodes(interface, exchange, state, motion):
    """Place the automata of the interface, and note the forces of the cells on its nodes."""
    follow(interface, state, motion)
    keep_grid_forces(interface, exchange, state)


@jit
def write_forces(cracking, motion, scratch):
    """Write the forces and torques of links and contacts of automata that may break; arguments as in `kicks_and_drifts`."""
    add_forces(cracking.medium, motion, scratch, cracking.contacts, cracking.contact_count, cracking.losses, 0.0, 0)


@jit
def join_forces(interface, exchange, grid, automata, sides, time, by_momentum, together):
    """Write the forces of the automata on the nodes of the interface, and those of sides, which are None without.

    Where both parts move together, write the sum of both for a kick of `time` [s] too.
    """
    gather_forces(interface, automata.scratch.force, exchange.automata_force)
    add_side_forces(sides, grid, automata, exchange)
    if together:
        assemble(interface, exchange, grid.state, grid.conditions, time, by_momentum)
