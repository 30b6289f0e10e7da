"""One tick of the grid and of the automata on one state.

Both move by kick, drift, kick. In lockstep (one micro-step) an interface node feels the sum of both forces, m a = F with the
masses of both: leapfrog for the whole, which conserves momentum and its discrete energy to rounding. With several micro-steps
the impulse scheme (reversible multiple time steps: M. Tuckerman, B. Berne, G. Martyna, J. Chem. Phys. 97 (1992) 1990): the
forces of the cells kick once before and once after the micro-steps of the automata, with which the interface nodes move; what
passes is impulses W^T F and velocities W v of micro-steps, never a force that is held.
"""

from __future__ import annotations

from typing import NamedTuple

from ..automata import motion as automata_motion
from ..automata.advance import advance as advance_automata
from ..automata.schedule import Part
from ..automata.state import Body, Motion, Scratch
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

# What functions that advance return.
DONE, INVERTED, TOO_FAST = 0, 1, 2


class GridPart(NamedTuple):
    """The grid, its state, nodes with conditions, scratch, tally, and room for events, of which there are none."""

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


class Seam(NamedTuple):
    """The interface, for kernels."""

    interface: Interface
    exchange: Exchange


class Steps(NamedTuple):
    """Lengths and numbers of the steps of both parts.

    Attributes:
        step: internal step [s].
        micro: micro-steps of the automata in it.
        scheme: see `exchange.SCHEMES`.
        speed_limit: of automata [m/s].
    """

    step: float
    micro: int
    scheme: int
    speed_limit: float


@jit
def update_automata_forces(part, seam):
    """Write the forces and torques of the links, and what of them acts on interface nodes."""
    scratch, edges = part.scratch, part.edges
    # No step, so that none of the inputs is looked at.
    advance_automata(
        part.body, part.part, part.reference, part.motion, scratch, edges.load.automata, edges.load_before, edges.load,
        edges.load_before, edges.grip, edges.grip_before, part.tallies, 0.0, 0, 0.0,
    )  # fmt: skip
    gather_forces(seam.interface, scratch.force, seam.exchange.automata_force)


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
    """Kick all nodes for half a step and drift them for a whole one."""
    count = len(part.grid.reference)
    grid_kernels.kick(part.grid, part.state, step, 0, count)
    grid_kernels.drift(part.grid, part.state, step, 0, count)
    grid_kernels.begin_conditions(part.grid, part.state, part.conditions, factors, row, step)


@jit
def update_grid_forces(part, seam, step, tick):
    """Write the forces of the cells; return a cell that is inverted, or -1."""
    failed = grid_kernels.forces(
        part.grid, part.state, part.conditions.groups, part.corner, step, tick, part.events, part.counts
    )
    keep_grid_forces(seam.interface, seam.exchange, part.state)
    return failed


@jit
def finish_grid(part, step):
    """Kick all nodes for the second half of a step."""
    grid_kernels.kick(part.grid, part.state, step, 0, len(part.grid.reference))
    grid_kernels.finish_conditions(part.grid, part.state, part.conditions, step, part.tally)


@jit
def tick_together(grid, automata, seam, factors, row, steps, tick):
    """Advance by a tick in lockstep; return a cell that is inverted, or -1, and the largest squared speed of automata."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    scratch, half = automata.scratch, 0.5 * steps.step
    keep_before(automata.edges, automata.motion, scratch.force, scratch.torque)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, step)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    kick_automata(automata, half)
    automata_motion.drift(automata.motion, step, 0, automata.body.kind.size)
    follow(interface, state, automata.motion)
    update_automata_forces(automata, seam)
    failed = update_grid_forces(grid, seam, step, tick)
    assemble(interface, exchange, state, grid.conditions, half, steps.scheme)
    keep_velocities(interface, exchange, state)
    finish_grid(grid, step)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    fastest = kick_automata(automata, half)
    follow(interface, state, automata.motion)
    settle_edges(automata, step)
    return failed, fastest


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
def micro_step(grid, automata, seam, time, scheme):
    """Advance automata and interface nodes by `time` [s]; return the largest squared speed of automata."""
    state, motion = grid.state, automata.motion
    keep_before(automata.edges, motion, automata.scratch.force, automata.scratch.torque)
    kick_nodes(grid, seam, 0.5 * time, scheme)
    kick_automata(automata, 0.5 * time)
    drift_nodes(grid, seam, time)
    automata_motion.drift(motion, time, 0, automata.body.kind.size)
    follow(seam.interface, state, motion)
    update_automata_forces(automata, seam)
    kick_nodes(grid, seam, 0.5 * time, scheme)
    fastest = kick_automata(automata, 0.5 * time)
    follow(seam.interface, state, motion)
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
def tick_with_impulses(grid, automata, seam, factors, row, steps, tick):
    """Advance by a tick with several micro-steps of the automata; see `tick_together`."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    keep_displacements(grid, seam)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, step)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    begin_micro_steps(grid, seam)
    follow(interface, state, automata.motion)
    fastest = 0.0
    for _ in range(steps.micro):
        fastest = micro_step(grid, automata, seam, step / steps.micro, steps.scheme)
    use_mean_velocities(grid, seam, step)
    failed = update_grid_forces(grid, seam, step, tick)
    end_micro_steps(grid, seam)
    keep_velocities(interface, exchange, state)
    finish_grid(grid, step)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    follow(interface, state, automata.motion)
    return failed, fastest


@jit
def tick_literally(grid, automata, seam, factors, row, steps, tick):
    """Advance by a tick as steps 2 to 4 of Psakhie et al. say, which is unstable; see `tick_together`.

    The automata make their steps first, those of the interface with the velocity that the nodes had; then the nodes feel the
    mean of the forces of the automata, and take the automata with them to where they come.
    """
    interface, exchange, state, motion = seam.interface, seam.exchange, grid.state, automata.motion
    time, fastest = steps.step / steps.micro, 0.0
    for row_ in range(interface.nodes.size):
        exchange.given[row_, 0] = exchange.given[row_, 1] = 0.0
    for _ in range(steps.micro):
        keep_before(automata.edges, motion, automata.scratch.force, automata.scratch.torque)
        kick_automata(automata, 0.5 * time)
        follow_velocities(interface, state, motion)
        automata_motion.drift(motion, time, 0, automata.body.kind.size)
        update_automata_forces(automata, seam)
        for row_ in range(interface.nodes.size):
            exchange.given[row_, 0] += exchange.automata_force[row_, 0] / steps.micro
            exchange.given[row_, 1] += exchange.automata_force[row_, 1] / steps.micro
        fastest = kick_automata(automata, 0.5 * time)
        follow_velocities(interface, state, motion)
        settle_edges(automata, time)
    exchange.automata_force[:] = exchange.given
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.scheme)
    begin_grid(grid, factors, row, steps.step)
    follow(interface, state, motion)
    failed = update_grid_forces(grid, seam, steps.step, tick)
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.scheme)
    finish_grid(grid, steps.step)
    follow(interface, state, motion)
    return failed, fastest


@jit
def follow_velocities(interface, state, motion):
    """Give the automata of the interface the velocities of their nodes, and leave them where they are."""
    hang(interface, state.velocity, motion.velocity)


@jit
def failure_of(failed, fastest, speed_limit, tick, failure_out):
    """Return the status of a tick, and note where and when it failed."""
    if failed >= 0:
        failure_out[0], failure_out[1] = failed, tick
        return INVERTED
    if not fastest <= speed_limit * speed_limit:
        failure_out[1] = tick
        return TOO_FAST
    return DONE


# One function for each scheme, so that a run compiles its own alone.


@jit
def advance_together(grid, automata, seam, factors, steps, tick, failure_out):
    """Advance by whole ticks in lockstep.

    Args:
        grid: a `GridPart`.
        automata: an `AutomataPart`.
        seam: a `Seam`.
        factors: of the signals of the grid in the middle of each tick, shape (ticks, signals); how many rows, so many ticks.
        steps: a `Steps`.
        tick: at the beginning.
        failure_out: where a cell is inverted, its number; and the tick at which anything failed, shape (2,).

    Returns:
        DONE, INVERTED or TOO_FAST.
    """
    for row in range(len(factors)):
        failed, fastest = tick_together(grid, automata, seam, factors, row, steps, tick + row + 1)
        status = failure_of(failed, fastest, steps.speed_limit, tick + row + 1, failure_out)
        if status != DONE:
            return status
    return DONE


@jit
def advance_with_impulses(grid, automata, seam, factors, steps, tick, failure_out):
    """Advance by whole ticks with several micro-steps in each; see `advance_together`."""
    for row in range(len(factors)):
        failed, fastest = tick_with_impulses(grid, automata, seam, factors, row, steps, tick + row + 1)
        status = failure_of(failed, fastest, steps.speed_limit, tick + row + 1, failure_out)
        if status != DONE:
            return status
    return DONE


@jit
def advance_literally(grid, automata, seam, factors, steps, tick, failure_out):
    """Advance by whole ticks with the paper's sub-steps; see `advance_together`."""
    for row in range(len(factors)):
        failed, fastest = tick_literally(grid, automata, seam, factors, row, steps, tick + row + 1)
        status = failure_of(failed, fastest, steps.speed_limit, tick + row + 1, failure_out)
        if status != DONE:
            return status
    return DONE
