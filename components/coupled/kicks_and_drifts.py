"""Kicks and drifts of grid and automata, of which the ticks of all schemes are made, and the tuples that they take.

Automata whose links all hold are swept: in one pass through memory they drift, their forces are computed, and they are kicked
(`automata.linked_sweep`). Of those that the interface or an input moves, a sweep notes what they were before the kick, and the
rest is done here. Automata that may break take a pass for each of these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata import motion as automata_motion
from ..automata.contact import Contacts
from ..automata.cracking_steps import Judgement, Medium, add_forces, judge_bonds
from ..automata.kernel_arrays import Body, Motion, Scratch
from ..automata.link_release import TRAVEL
from ..automata.linked_sweep import sweep
from ..automata.sweep_order import Part
from ..grid import kernels as grid_kernels
from ..grid.kernel_arrays import Conditions, Grid, State, Yields
from ..grid.mesh import IntArray
from ..support.float_arrays import FloatArray
from ..support.jit import internal
from .applied_loads import Edges, push_and_hold, settle_grip, settle_loads
from .exchange import Exchange, follow, gather_forces, keep_grid_forces
from .interface import Interface
from .side_contacts import Sides


class GridPart(NamedTuple):
    """The grid, its state, nodes with conditions, scratch, tally, and the events of cells that yield."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray
    tally: FloatArray
    yields: Yields


class AutomataPart(NamedTuple):
    """The automata, the order of the work on them, centres in the grid's coordinates, state, scratch, edges, and tallies.

    Attributes:
        body: those of the interface have no end of mass: no force moves them, as they follow their nodes.
        part: the order of the work.
        reference: centres before anything moved, in the coordinates of the grid, shape (n, 2) [m].
        motion: state.
        scratch: its forces and torques are part of the state.
        edges: loads and grips.
        marked: automata of the interface, and those that loads or grips act on, in increasing order, shape (m,).
        kept: scratch for these, see `linked_sweep.sweep`, shape (m, 6).
        tallies: of loads and of grips, part of the state.
    """

    body: Body
    part: Part
    reference: FloatArray
    motion: Motion
    scratch: Scratch
    edges: Edges
    marked: IntArray
    kept: FloatArray
    tallies: FloatArray


class Cracking(NamedTuple):
    """The histories and contacts of automata that break or yield; None stands for automata that stay linked and elastic.

    Attributes:
        medium: a `Medium`; its bonds are part of the state.
        judgement: scratch.
        contacts: part of the state.
        contact_count: how many contacts there are.
        losses: see `link_release.FRACTURE`, part of the state.
        most_travel: how far the fastest automaton may move before contacts are found anew [m].
        sides: sides of the grid that automata touch; None without.
    """

    medium: Medium
    judgement: Judgement
    contacts: Contacts
    contact_count: int
    losses: FloatArray
    most_travel: float
    sides: Sides | None


class Seam(NamedTuple):
    """The interface, for kernels."""

    interface: Interface
    exchange: Exchange


class Steps(NamedTuple):
    """Lengths and numbers of the steps of both parts.

    Attributes:
        step: internal step [s].
        micro: steps of the automata in it.
        by_momentum: whether interface nodes get the mean of the velocities of both sides; see `exchange.kicked`.
        speed_limit: of automata [m/s].
        swept: 1 where one sweep moves the automata, computes their forces and kicks them, as links all hold;
            else None, and what follows a sweep is not compiled.
    """

    step: float
    micro: int
    by_momentum: bool
    speed_limit: float
    swept: int | None


def drive_body(body: Body, driven: IntArray) -> Body:
    """Return a body some of whose automata are of kinds that no force moves: they follow something else, and turn freely."""
    source, place = np.unique(body.kind[driven], return_inverse=True)
    kinds, rows = body.kind.copy(), np.concatenate([np.arange(len(body.mass)), source])
    kinds[driven] = len(body.mass) + place
    names = ("face", "share", "missing", "volume", "mass", "inertia")
    body = body._replace(kind=kinds, **{name: getattr(body, name)[rows] for name in names})
    body.mass[-len(source) :] = np.inf
    return body


# -- the automata ---------------------------------------------------------------------------------------------------------


@internal
def update_automata_forces(automata, cracking, seam, steps, time, tick, moves):
    """Write the forces and torques of links and contacts, and what of them acts on interface nodes; or sweep.

    Args:
        automata: an `AutomataPart`.
        cracking: a `Cracking`, its links judged; None for automata that stay linked and elastic.
        seam: a `Seam`.
        steps: a `Steps`.
        time: since the forces were computed last [s].
        tick: number of the step of the automata.
        moves: see `linked_sweep.STILL`; what else a sweep does.

    Returns:
        0, or another number where an automaton is too fast; only a sweep looks at that.
    """
    motion, scratch, fast = automata.motion, automata.scratch, 0
    if cracking is None:
        limit = steps.speed_limit * steps.speed_limit
        fast = sweep(automata.body, automata.part, motion, scratch, automata.marked, automata.kept, time, limit, moves)
    else:
        add_forces(cracking.medium, motion, scratch, cracking.contacts, cracking.contact_count, cracking.losses, time, tick)
    gather_forces(seam.interface, scratch.force, seam.exchange.automata_force)
    return fast


@internal
def must_break(automata, cracking, time, tick):
    """Let links weaken and yield after a drift of `time` [s]; return whether some break, or may be made anew, before that."""
    motion, scratch, judgement = automata.motion, automata.scratch, cracking.judgement
    contacts, count = cracking.contacts, cracking.contact_count
    return judge_bonds(cracking.medium, motion, scratch, judgement, contacts, count, cracking.losses, time, tick)


@internal
def note_travel(automata, cracking, time):
    """Add the way of the fastest automaton in a drift of `time` [s] to what decides when contacts are found anew."""
    velocity, largest = automata.motion.velocity, 0.0
    for i in range(automata.body.kind.size):
        square = velocity[i, 0] * velocity[i, 0] + velocity[i, 1] * velocity[i, 1]
        if square > largest:
            largest = square
    cracking.losses[TRAVEL] += time * np.sqrt(largest)


@internal
def kick_automata(automata, time, limit):
    """Kick all automata, and hold some of them; return the largest squared speed, see `motion.held_speed`."""
    scratch, motion = automata.scratch, automata.motion
    fastest = automata_motion.kick(automata.body, motion, scratch.force, scratch.torque, time, 0, automata.body.kind.size)
    push_and_hold(automata.edges, automata.body, automata.reference, motion, time, automata.tallies[0])
    return automata_motion.held_speed(motion.velocity, fastest, limit)


@internal
def kick_marked(automata, time):
    """Kick the marked automata, the others having been kicked by a sweep; return their largest squared speed."""
    body, motion, force, torque = automata.body, automata.motion, automata.scratch.force, automata.scratch.torque
    for row in range(automata.marked.size):
        i = automata.marked[row]
        by = time / body.mass[body.kind[i]]
        motion.velocity[i, 0] += by * force[i, 0]
        motion.velocity[i, 1] += by * force[i, 1]
        motion.spin[i] += time / body.inertia[body.kind[i]] * torque[i]
    push_and_hold(automata.edges, body, automata.reference, motion, time, automata.tallies[0])
    largest = 0.0
    for row in range(automata.marked.size):
        i = automata.marked[row]
        square = motion.velocity[i, 0] * motion.velocity[i, 0] + motion.velocity[i, 1] * motion.velocity[i, 1]
        largest = square if square > largest or square != square else largest
    return largest


@internal
def begin_automata(automata, seam, state, steps, time, first):
    """Let the automata begin a step, the interface nodes having drifted: half a kick, and the drift where no sweep makes it.

    Args:
        automata: an `AutomataPart`.
        seam: a `Seam`.
        state: of the grid.
        steps: a `Steps`.
        time: of their step [s].
        first: whether no sweep has kicked them yet.
    """
    motion = automata.motion
    if steps.swept is None:
        kick_automata(automata, 0.5 * time, steps.speed_limit * steps.speed_limit)
        automata_motion.drift(motion, time, 0, automata.body.kind.size)
    elif first:
        kick_automata(automata, 0.5 * time, steps.speed_limit * steps.speed_limit)
    else:
        kick_marked(automata, 0.5 * time)
    follow(seam.interface, state, motion)
    if steps.swept is not None:
        # They are where they will be: the sweep lets them drift too.
        for place in range(seam.interface.automata.size):
            i = seam.interface.automata[place]
            motion.velocity[i, 0] = motion.velocity[i, 1] = 0.0


@internal
def finish_automata(automata, steps, time):
    """Kick the automata for the second half of a step where no sweep has; return the largest squared speed of these."""
    if steps.swept is None:
        return kick_automata(automata, 0.5 * time, steps.speed_limit * steps.speed_limit)
    motion = automata.motion
    for row in range(automata.marked.size):
        i = automata.marked[row]
        motion.velocity[i, 0], motion.velocity[i, 1] = automata.kept[row, 2], automata.kept[row, 3]
        motion.spin[i] = automata.kept[row, 5]
    return kick_marked(automata, 0.5 * time)


@internal
def settle_edges(automata, time):
    """Tally what loads and grip gave the automata in a micro-step of `time` [s] that has ended."""
    motion, scratch = automata.motion, automata.scratch
    settle_loads(automata.edges, motion, time, automata.tallies[0])
    settle_grip(
        automata.edges, automata.body, automata.reference, motion, scratch.force, scratch.torque, time, automata.tallies[1]
    )


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
        seam: a `Seam`, which keeps the forces of the grid on the interface.
        step: internal step [s].
        tick: at the end of this one.
        again: whether the next tick follows in this call: then nodes without conditions start it.

    Returns:
        A cell that is inverted, or -1.
    """
    cells, nodes = len(grid.grid.cells), len(grid.grid.reference)
    failed = grid_kernels.advance_cells(grid.grid, grid.state, grid.corner, step, tick, grid.yields, 0, cells)
    grid_kernels.finish_nodes(grid.grid, grid.state, grid.corner, step, again, 0, nodes)
    grid_kernels.finish_forces(grid.grid, grid.state, grid.conditions.groups, grid.corner)
    keep_grid_forces(seam.interface, seam.exchange, grid.state)
    return failed
