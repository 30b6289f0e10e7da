"""The two parts of a coupled medium as kernels take them, and the kicks and drifts of which all schemes are made."""

from __future__ import annotations

from typing import NamedTuple

from ..automata.contacts import Contacts
from ..automata.lattice import Body, Motion, Scratch, update_ghost_velocities
from ..automata.linked import link_forces
from ..automata.loads import count_fast, drift, kick, largest_speed
from ..automata.release import TRAVEL
from ..automata.ticks import Specimen, add_forces
from ..grid import kernels as grid_kernels
from ..grid.kernel_arrays import Conditions, Grid, State, Yields
from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .exchange import Exchange, assemble, follow, gather_forces, keep_grid_forces
from .interface import Interface
from .loads import Edges, push_and_hold, settle_grip, settle_loads
from .side_contacts import Sides, add_side_forces


class GridPart(NamedTuple):
    """The grid, its state, nodes with conditions, scratch, tally, and the events of cells that yield."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray
    tally: FloatArray
    yields: Yields


class AutomataPart(NamedTuple):
    """The automata on their lattice.

    Attributes:
        body: with centres in the coordinates of the grid. Automata of the interface have infinite mass: no force moves them, as
            they follow their nodes; they turn freely.
        motion: fields.
        scratch: fields.
        edges: loads and grips.
    """

    body: Body
    motion: Motion
    scratch: Scratch
    edges: Edges


class Cracking(NamedTuple):
    """The histories and contacts of automata that break or yield; None where automata stay linked and elastic.

    Attributes:
        specimen: an `automata.ticks.Specimen` with the same motion and scratch.
        contacts: part of the state.
        most_travel: how far the fastest automaton may move before contacts are found again [m].
        sides: sides of the grid that automata touch; None without.
    """

    specimen: Specimen
    contacts: Contacts
    most_travel: float
    sides: Sides | None


class Seam(NamedTuple):
    """The interface, for kernels."""

    interface: Interface
    exchange: Exchange


# -- the automata ---------------------------------------------------------------------------------------------------------


@internal
def update_automata_forces(automata, cracking, seam, time, tick):
    """Write the forces and torques of links and contacts, and the forces that act on interface nodes.

    Args:
        automata: an `AutomataPart`.
        cracking: a `Cracking`, its links judged; None for automata that stay linked and elastic.
        seam: a `Seam`.
        time: since the forces were computed last [s].
        tick: number of the step of the automata.
    """
    if cracking is None:
        link_forces(automata.body, automata.motion, automata.scratch)
    else:
        add_forces(cracking.specimen, cracking.contacts, time, tick)
    gather_forces(seam.interface, automata.body.layout.place, automata.scratch.forces, seam.exchange.automata_force)


@internal
def note_travel(automata, cracking, time):
    """Add the way of the fastest automaton in a drift of `time` [s] to the distance after which contacts are found again."""
    cracking.specimen.losses[TRAVEL] += time * largest_speed(automata.motion)


@internal
def kick_automata(automata, time):
    """Kick all automata with forces and loads, and hold some of them."""
    kick(automata.body, automata.motion, automata.scratch.forces, time)
    push_and_hold(automata.edges, automata.body, automata.motion, time)
    update_ghost_velocities(automata.body.layout, automata.motion)


@internal
def move_automata(automata, seam, state, time):
    """Begin a step of the automata, the interface nodes having drifted: half a kick, and the drift."""
    kick_automata(automata, 0.5 * time)
    drift(automata.motion, time)
    follow(seam.interface, automata.body.layout, state, automata.motion)


@internal
def are_too_fast(automata, limit):
    """Return how many automata are faster than a limit [m/s]."""
    return count_fast(automata.motion, limit * limit)


@internal
def settle_edges(automata, time):
    """Tally work and impulse of loads and grip in a micro-step of `time` [s] that has ended."""
    settle_loads(automata.edges, automata.motion, time)
    settle_grip(automata.edges, automata.body, automata.motion, automata.scratch.forces, time)


@jit
def load_forces(place, force, torque, forces):
    """Write the forces and torques of the state, shapes (n, 2) and (n,), to fields."""
    for i in range(place.size):
        forces.x[place[i]], forces.y[place[i]], forces.torque[place[i]] = force[i, 0], force[i, 1], torque[i]


@jit
def store_forces(place, force, torque, forces):
    """Write the forces and torques of fields to the state."""
    for i in range(place.size):
        force[i, 0], force[i, 1], torque[i] = forces.x[place[i]], forces.y[place[i]], forces.torque[place[i]]


# -- the grid -------------------------------------------------------------------------------------------------------------


@internal
def begin_grid(grid, factors, row, step):
    """Kick all nodes for half a step and drift them for a whole one, where `finish_cells` has not yet."""
    if row == 0:
        count = len(grid.grid.reference)
        grid_kernels.kick(grid.grid, grid.state, step, 0, count)
        grid_kernels.drift(grid.grid, grid.state, step, 0, count)
    grid_kernels.begin_conditions(grid.grid, grid.state, grid.conditions, factors, row, step)


@internal
def finish_cells(grid, seam, step, tick, again):
    """Advance the cells, kick the nodes without conditions, and finish the forces on the others.

    Args:
        grid: a `GridPart`.
        seam: a `Seam`.
        step: internal step [s].
        tick: at the end of this one.
        again: whether the next tick follows in this call: then nodes without conditions begin it at once.

    Returns:
        A cell that is inverted, or -1.
    """
    cells, nodes = len(grid.grid.cells), len(grid.grid.reference)
    failed = grid_kernels.advance_cells(grid.grid, grid.state, grid.corner, step, tick, grid.yields, 0, cells)
    grid_kernels.finish_nodes(grid.grid, grid.state, grid.corner, step, again, 0, nodes)
    grid_kernels.finish_forces(grid.grid, grid.state, grid.conditions.groups, grid.corner)
    keep_grid_forces(seam.interface, seam.exchange, grid.state)
    return failed


# -- the start ------------------------------------------------------------------------------------------------------------


@jit
def follow_nodes(seam, grid, automata):
    """Place the automata of the interface, and note the forces of the cells on its nodes."""
    follow(seam.interface, automata.body.layout, grid.state, automata.motion)
    keep_grid_forces(seam.interface, seam.exchange, grid.state)


@jit
def join_forces(grid, automata, cracking, seam, steps, together):
    """Write the first forces of the automata, also on the nodes of the interface, and those of sides.

    Where both parts move together, write the sum of both for a kick of half a step too.
    """
    update_automata_forces(automata, cracking, seam, 0.0, 0)
    if cracking is not None:
        add_side_forces(cracking.sides, grid, automata, seam.exchange)
    if together:
        assemble(seam.interface, seam.exchange, grid.state, grid.conditions, 0.5 * steps.step, steps.by_momentum)
