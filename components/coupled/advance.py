"""One tick of the grid and of the automata on one state.

Both move by kick, drift, kick. In lockstep (one micro-step) an interface node feels the sum of both forces, m a = F with the
masses of both: leapfrog for the whole, which conserves momentum and its discrete energy to rounding. With several micro-steps
the impulse scheme (reversible multiple time steps: M. Tuckerman, B. Berne, G. Martyna, J. Chem. Phys. 97 (1992) 1990): the
forces of the cells kick once before and once after the micro-steps of the automata, with which the interface nodes move; what
passes is impulses W^T F and velocities W v of micro-steps, never a force that is held.

A tick goes on in stages, so that `advance` can stop where the lists of contacts and of broken links need more room, and go on
from there. What a run does not need is not compiled: arguments that are None take their branches with them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata import motion as automata_motion
from ..automata.advance import advance as advance_automata
from ..automata.contact import Contacts, dashpot_power
from ..automata.cracking import Judgement, Medium, add_forces, judge_bonds
from ..automata.release import DAMPING, TRAVEL
from ..automata.schedule import Part
from ..automata.state import Body, Motion, Scratch
from ..automata.ties import add_ties
from ..grid import kernels as grid_kernels
from ..grid.layout import BOUNDARY_ANGULAR, BOUNDARY_IMPULSE, WORK, Conditions, Grid, State
from ..grid.mesh import IntArray
from ..support.arrays import FloatArray
from ..support.jit import jit
from .edges import Edges, keep_before, push_and_hold, settle_grip, settle_loads
from .exchange import (
    Exchange,
    assemble,
    follow,
    gather_forces,
    hang,
    keep_grid_forces,
    keep_velocities,
    kicked,
    settle_kick,
)
from .interface import Interface

# What `advance` returns: all ticks are done, one has failed, or what has to be done before it goes on.
DONE, INVERTED, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3, 4
# Entries of `progress`: the tick in the call, the step of the automata in it, and the stage of that.
ROW, MICRO, STAGE, PROGRESS = 0, 1, 2, 3
# Stages: before a tick, before a step of the automata, after its links have been judged.
BEGIN, MOVE, ACT = 0, 1, 2


class GridPart(NamedTuple):
    """The grid, its state, nodes with conditions, scratch, tally, and room for events with their number."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray
    tally: FloatArray
    events: FloatArray
    counts: IntArray


class AutomataPart(NamedTuple):
    """The automata, the order of the work on them, centres in the grid's coordinates, state, scratch, edges, and tallies."""

    body: Body
    part: Part
    reference: FloatArray
    motion: Motion
    scratch: Scratch
    edges: Edges
    tallies: FloatArray


class Cracking(NamedTuple):
    """The histories and contacts of automata that break or yield; None stands for automata that stay linked and elastic.

    Attributes:
        medium: a `Medium`; its bonds are part of the state.
        judgement: scratch.
        contacts: part of the state.
        contact_count: how many contacts there are.
        losses: see `release.FRACTURE`, part of the state.
        most_travel: how far the fastest automaton may move before contacts are found anew [m].
    """

    medium: Medium
    judgement: Judgement
    contacts: Contacts
    contact_count: int
    losses: FloatArray
    most_travel: float


class Seam(NamedTuple):
    """The interface, for kernels."""

    interface: Interface
    exchange: Exchange


class Steps(NamedTuple):
    """Lengths and numbers of the steps of both parts.

    Attributes:
        step: internal step [s].
        micro: steps of the automata in it.
        scheme: see `exchange.SCHEMES`.
        speed_limit: of automata [m/s].
    """

    step: float
    micro: int
    scheme: int
    speed_limit: float


@jit
def update_automata_forces(part, cracking, ties, seam, time, tick):
    """Write the forces and torques of links and contacts, and what of them acts on interface nodes.

    Args:
        part: an `AutomataPart`.
        cracking: a `Cracking`, its links judged; None for automata that stay linked and elastic.
        ties: `Ties` of these, None without.
        seam: a `Seam`.
        time: since the forces were computed last [s].
        tick: number of the step of the automata.
    """
    motion, scratch, edges = part.motion, part.scratch, part.edges
    if cracking is None:
        # No step, so that none of the inputs is looked at.
        advance_automata(
            part.body, part.part, part.reference, motion, scratch, edges.load.automata, edges.load_before, edges.load,
            edges.load_before, edges.grip, edges.grip_before, part.tallies, 0.0, 0, 0.0,
        )  # fmt: skip
        if ties is not None:
            add_ties(part.body, ties, motion, scratch)
    else:
        add_forces(cracking.medium, motion, scratch, cracking.contacts, cracking.contact_count, cracking.losses, time, tick)
    gather_forces(seam.interface, scratch.force, seam.exchange.automata_force)


@jit
def must_break(part, cracking, tick):
    """Let links weaken and yield; return whether some have to break, or may be made anew, before that."""
    motion, scratch, judgement = part.motion, part.scratch, cracking.judgement
    contacts, count = cracking.contacts, cracking.contact_count
    return judge_bonds(cracking.medium, motion, scratch, judgement, contacts, count, cracking.losses, tick)


@jit
def note_travel(part, cracking, time):
    """Add the way of the fastest automaton in a drift of `time` [s] to what decides when contacts are found anew."""
    velocity, largest = part.motion.velocity, 0.0
    for i in range(part.body.kind.size):
        square = velocity[i, 0] * velocity[i, 0] + velocity[i, 1] * velocity[i, 1]
        if square > largest:
            largest = square
    cracking.losses[TRAVEL] += time * np.sqrt(largest)


@jit
def kick_automata(part, time):
    """Kick all automata, those of the interface too, which then follow their nodes; return the largest squared speed."""
    scratch, motion = part.scratch, part.motion
    fastest = automata_motion.kick(part.body, motion, scratch.force, scratch.torque, time, 0, part.body.kind.size)
    push_and_hold(part.edges, part.body, part.reference, motion, time, part.tallies[0])
    return fastest


@jit
def settle_edges(part, time):
    """Tally what loads and grip gave the automata in a micro-step of `time` [s] that has ended."""
    settle_loads(part.edges, part.motion, time, part.tallies[0])
    settle_grip(
        part.edges, part.body, part.reference, part.motion, part.scratch.force, part.scratch.torque, time, part.tallies[1]
    )


@jit
def begin_grid(part, factors, row, step):
    """Kick all nodes for half a step and drift them for a whole one, where `finish_cells` has not yet."""
    if row == 0:
        count = len(part.grid.reference)
        grid_kernels.kick(part.grid, part.state, step, 0, count)
        grid_kernels.drift(part.grid, part.state, step, 0, count)
    grid_kernels.begin_conditions(part.grid, part.state, part.conditions, factors, row, step)


@jit
def finish_cells(part, seam, step, tick, again):
    """Advance the cells, and kick the nodes without conditions; of the others write the forces.

    Args:
        part: a `GridPart`.
        seam: a `Seam`.
        step: internal step [s].
        tick: at the end of this one.
        again: whether the next tick follows in this call: then nodes without conditions begin it at once.

    Returns:
        A cell that is inverted, or -1.
    """
    grid, state, failed = part.grid, part.state, np.int64(-1)
    for place in range(len(grid.parts) - 1):
        bad = grid_kernels.advance_part(grid, state, part.corner, place, step, tick, again, part.events, part.counts)
        failed = bad if failed < 0 else failed
    grid_kernels.finish_tile(grid, state, part.corner, len(grid.tiles) - 2, step, again)
    grid_kernels.join(state, part.conditions.groups)
    keep_grid_forces(seam.interface, seam.exchange, state)
    return failed


# -- one step of the automata in a tick: lockstep ---------------------------------------------------------------------------


@jit
def move_together(grid, automata, seam, factors, row, steps):
    """Kick for half a step and drift."""
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    keep_before(automata.edges, automata.motion, automata.scratch.force, automata.scratch.torque)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, steps.step)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    kick_automata(automata, half)
    automata_motion.drift(automata.motion, steps.step, 0, automata.body.kind.size)
    follow(interface, state, automata.motion)


@jit
def finish_together(grid, automata, seam, steps, tick, again):
    """Advance the cells and kick for the second half of a step, the forces of the automata being there.

    Returns:
        A cell that is inverted, or -1, and the largest squared speed of automata.
    """
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    failed = finish_cells(grid, seam, steps.step, tick, again)
    assemble(interface, exchange, state, grid.conditions, half, steps.scheme)
    keep_velocities(interface, exchange, state)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    fastest = kick_automata(automata, half)
    follow(interface, state, automata.motion)
    settle_edges(automata, steps.step)
    return failed, fastest


# -- several steps of the automata in a tick: impulses --------------------------------------------------------------------


@jit
def kick_nodes(grid, seam, time, scheme):
    """Let the forces of the automata kick the interface nodes for `time` [s]."""
    interface, exchange, conditions, velocity = seam.interface, seam.exchange, grid.conditions, grid.state.velocity
    keep_velocities(interface, exchange, grid.state)
    for row in range(interface.nodes.size):
        n, i = interface.nodes[row], exchange.places[row]
        carried = interface.mass[row]
        for k in range(2):
            force = exchange.automata_force[row, k]
            if conditions.prescribed[i, k]:
                exchange.given[row, k] += time * force
            else:
                velocity[n, k] = kicked(velocity[n, k], time, 0.0, force, conditions.mass[i] - carried, carried, scheme)
    settle_kick(interface, exchange, grid.state, conditions, 0.0, time)


@jit
def begin_micro_steps(grid, seam):
    """Take back the drift of the interface nodes in `begin_grid`: they drift with the micro-steps."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        for k in range(2):
            grid.state.displacement[n, k] = seam.exchange.start[row, k]
            seam.exchange.given[row, k] = 0.0


@jit
def keep_displacements(grid, seam):
    """Note where the interface nodes are at the begin of a tick."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        seam.exchange.start[row, 0], seam.exchange.start[row, 1] = grid.state.displacement[n, 0], grid.state.displacement[n, 1]


@jit
def drift_nodes(grid, seam, time):
    """Move the interface nodes with their velocities for `time` [s]."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        grid.state.displacement[n, 0] += time * grid.state.velocity[n, 0]
        grid.state.displacement[n, 1] += time * grid.state.velocity[n, 1]


@jit
def begin_impulses(grid, automata, seam, factors, row, steps):
    """Let the cells kick for half a step, and drift the nodes of the grid alone."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    keep_displacements(grid, seam)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, step)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    begin_micro_steps(grid, seam)
    follow(interface, state, automata.motion)


@jit
def move_with_impulses(grid, automata, seam, time, scheme):
    """Let the automata kick for half a micro-step of `time` [s], and drift."""
    motion = automata.motion
    keep_before(automata.edges, motion, automata.scratch.force, automata.scratch.torque)
    kick_nodes(grid, seam, 0.5 * time, scheme)
    kick_automata(automata, 0.5 * time)
    drift_nodes(grid, seam, time)
    automata_motion.drift(motion, time, 0, automata.body.kind.size)
    follow(seam.interface, grid.state, motion)


@jit
def act_with_impulses(grid, automata, seam, time, scheme):
    """Let the automata kick for the second half of a micro-step; return their largest squared speed."""
    kick_nodes(grid, seam, 0.5 * time, scheme)
    fastest = kick_automata(automata, 0.5 * time)
    follow(seam.interface, grid.state, automata.motion)
    settle_edges(automata, time)
    return fastest


@jit
def use_mean_velocities(grid, seam, step):
    """Give the interface nodes the mean velocities of the tick, for the strains of the cells; note the present ones."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    for row in range(interface.nodes.size):
        n = interface.nodes[row]
        for k in range(2):
            exchange.before[row, k] = state.velocity[n, k]
            state.velocity[n, k] = (state.displacement[n, k] - exchange.start[row, k]) / step


@jit
def end_micro_steps(grid, seam):
    """Give the interface nodes their own velocities back, and let `finish_conditions` go on from these.

    What automata gave to prescribed components is taken up by the boundary, which therefore gave that back.
    """
    interface, exchange, state, conditions, tally = seam.interface, seam.exchange, grid.state, grid.conditions, grid.tally
    for row in range(interface.nodes.size):
        n, i = interface.nodes[row], exchange.places[row]
        share = conditions.share[i]
        for k in range(2):
            state.velocity[n, k] = exchange.before[row, k]
            if conditions.prescribed[i, k]:
                impulse = share * exchange.given[row, k]
                lever = grid.grid.reference[n, 1 - k] + 0.5 * (state.displacement[n, 1 - k] + exchange.start[row, 1 - k])
                tally[WORK] -= impulse * state.velocity[n, k]
                tally[BOUNDARY_IMPULSE + k] -= impulse
                tally[BOUNDARY_ANGULAR] -= lever * impulse if k == 1 else -lever * impulse
            else:
                conditions.begin[i, 4, k] = state.velocity[n, k]


@jit
def finish_impulses(grid, automata, seam, steps, tick, again):
    """Advance the cells and let them kick for the second half of a step; return a cell that is inverted, or -1."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    use_mean_velocities(grid, seam, step)
    failed = finish_cells(grid, seam, step, tick, again)
    end_micro_steps(grid, seam)
    keep_velocities(interface, exchange, state)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, step, grid.tally)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    follow(interface, state, automata.motion)
    return failed


# -- the sub-steps of the paper -------------------------------------------------------------------------------------------
#
# Steps 2 to 4 of Psakhie et al., which are unstable: the automata make their steps first, those of the interface with the
# velocity that the nodes had; then the nodes feel the mean of the forces of the automata, and take the automata along.


@jit
def begin_literally(seam):
    """Forget the forces of the last tick."""
    for row in range(seam.interface.nodes.size):
        seam.exchange.given[row, 0] = seam.exchange.given[row, 1] = 0.0


@jit
def move_literally(grid, automata, seam, time):
    """Kick and drift the automata for `time` [s]; those of the interface with the velocities of their nodes."""
    keep_before(automata.edges, automata.motion, automata.scratch.force, automata.scratch.torque)
    kick_automata(automata, 0.5 * time)
    follow_velocities(seam.interface, grid.state, automata.motion)
    automata_motion.drift(automata.motion, time, 0, automata.body.kind.size)


@jit
def act_literally(grid, automata, seam, time, micro):
    """Add to the mean of the forces, and kick the automata; return their largest squared speed."""
    exchange = seam.exchange
    for row in range(seam.interface.nodes.size):
        exchange.given[row, 0] += exchange.automata_force[row, 0] / micro
        exchange.given[row, 1] += exchange.automata_force[row, 1] / micro
    fastest = kick_automata(automata, 0.5 * time)
    follow_velocities(seam.interface, grid.state, automata.motion)
    settle_edges(automata, time)
    return fastest


@jit
def finish_literally(grid, automata, seam, factors, row, steps, tick, again):
    """Advance the grid with the mean of the forces of the automata; return a cell that is inverted, or -1."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    exchange.automata_force[:] = exchange.given
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.scheme)
    begin_grid(grid, factors, row, steps.step)
    follow(interface, state, automata.motion)
    failed = finish_cells(grid, seam, steps.step, tick, again)
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.scheme)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    follow(interface, state, automata.motion)
    return failed


@jit
def follow_velocities(interface, state, motion):
    """Give the automata of the interface the velocities of their nodes, and leave them where they are."""
    hang(interface, state.velocity, motion.velocity)


# -- the whole ------------------------------------------------------------------------------------------------------------


@jit
def advance(grid, automata, cracking, ties, seam, factors, steps, impulses, literal, tick, progress, failure_out):
    """Advance by whole ticks, or up to where links break or contacts have to be found anew.

    Args:
        grid: a `GridPart`.
        automata: an `AutomataPart`.
        cracking: a `Cracking`; None for automata that stay linked and elastic.
        ties: `Ties`, see `automata.ties`; None without.
        seam: a `Seam`.
        factors: of the signals of the grid in the middle of each tick, shape (ticks, signals); how many rows, so many ticks.
        steps: a `Steps`.
        impulses: 1 for several steps of the automata in a tick, else None.
        literal: 1 for the sub-steps of the paper, else None; with neither, both parts advance in lockstep.
        tick: at the beginning of the first row.
        progress: where to go on, and where this has stopped, shape (PROGRESS,); zeros at the beginning of a call.
        failure_out: where a cell is inverted, its number; and the tick at which anything failed, shape (2,).

    Returns:
        DONE, INVERTED or TOO_FAST; SEARCH before a step of the automata, BREAK in the middle of one.
    """
    # The kinds of steps are told apart here alone: each further function that gets all these tuples compiles for half a second.
    time, rows, fastest = steps.step / steps.micro, len(factors), 0.0
    while progress[ROW] < rows:
        row = progress[ROW]
        now, again, failed = tick + row + 1, row + 1 < rows, np.int64(-1)
        if progress[STAGE] == BEGIN:
            if impulses is not None:
                begin_impulses(grid, automata, seam, factors, row, steps)
            elif literal is not None:
                begin_literally(seam)
            progress[MICRO], progress[STAGE] = 0, MOVE
        while progress[MICRO] < steps.micro:
            own_tick = (now - 1) * steps.micro + progress[MICRO]
            if progress[STAGE] == MOVE:
                if cracking is not None:
                    if cracking.losses[TRAVEL] > cracking.most_travel:
                        return SEARCH
                if impulses is not None:
                    move_with_impulses(grid, automata, seam, time, steps.scheme)
                elif literal is not None:
                    move_literally(grid, automata, seam, time)
                else:
                    move_together(grid, automata, seam, factors, row, steps)
                progress[STAGE] = ACT
                if cracking is not None:
                    note_travel(automata, cracking, time)
                    if must_break(automata, cracking, own_tick):
                        return BREAK
            update_automata_forces(automata, cracking, ties, seam, time, own_tick)
            if impulses is not None:
                fastest = act_with_impulses(grid, automata, seam, time, steps.scheme)
            elif literal is not None:
                fastest = act_literally(grid, automata, seam, time, steps.micro)
            else:
                failed, fastest = finish_together(grid, automata, seam, steps, now, again)
            if cracking is not None:
                if cracking.medium.ground.damping > 0.0:
                    # Between the two halves of the kick, so that these are the mean velocities.
                    power = dashpot_power(cracking.contacts, cracking.contact_count, automata.motion.velocity)
                    cracking.losses[DAMPING] += time * power
            progress[MICRO], progress[STAGE] = progress[MICRO] + 1, MOVE
        if impulses is not None:
            failed = finish_impulses(grid, automata, seam, steps, now, again)
        elif literal is not None:
            failed = finish_literally(grid, automata, seam, factors, row, steps, now, again)
        if failed >= 0 or not fastest <= steps.speed_limit * steps.speed_limit:
            failure_out[0], failure_out[1] = failed, now
            return INVERTED if failed >= 0 else TOO_FAST
        progress[ROW], progress[STAGE] = row + 1, BEGIN
    return DONE
