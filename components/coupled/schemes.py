"""Three schemes for a tick (an internal step), each in four stages: begin tick, begin step, end step, end tick.

Both parts move by kick, drift, kick. In `Lockstep` (one step of the automata per tick) an interface node is accelerated by both
forces, m a = F with both masses. This is leapfrog for the whole body; momentum and discrete energy are conserved to rounding.

`Impulses` is a reversible multiple-time-step scheme (M. Tuckerman, B. Berne, G. Martyna, J. Chem. Phys. 97 (1992) 1990). The
cell forces kick once before and once after the micro-steps of the automata; interface nodes move with the micro-steps. In each
the parts exchange impulses W^T F and velocities W v (W interpolates from nodes to automata); no force is held constant longer.

`Literal` follows the sub-steps of Psakhie et al. as written (section 2.3, steps 2 to 4), which are unstable. The automata make
their steps first; interface automata move with the previous velocity of their nodes. The mean force of the automata then
acts on the nodes, and the automata move to the nodes' new positions.
"""

from __future__ import annotations

from typing import NamedTuple

from ..automata.loads import drift
from ..grid import kernels as grid_kernels
from ..grid.kernel_arrays import BOUNDARY_ANGULAR, BOUNDARY_IMPULSE, WORK
from ..support.dispatch import dispatch_by_class
from ..support.jit import internal, spliced
from .edge_loads import save_tick_start, tally_edges
from .exchange import (
    assemble_interface_forces,
    copy_interface_rows,
    kicked_velocity,
    move_interface_automata,
    set_interface_velocities,
    tally_kick,
)
from .parts import finish_cells, kick_and_drift_grid, kick_automata


class Lockstep(NamedTuple):
    """One step of the automata in a tick.

    Attributes:
        step: internal step [s].
        micro: number of steps of the automata per tick.
        by_momentum: whether interface nodes get the mass-weighted mean of the velocities of both sides; see
            `exchange.kicked_velocity`.
        speed_limit: largest speed of automata [m/s].
    """

    step: float
    micro: int
    by_momentum: bool
    speed_limit: float


class Impulses(Lockstep):
    """Several steps of the automata (micro-steps) per tick; attributes as in `Lockstep`."""


class Literal(Lockstep):
    """The sub-steps of Psakhie et al., as written; attributes as in `Lockstep`."""


@dispatch_by_class
def begin_tick(steps, grid, automata, seam, factors, row):
    """Begin a tick; `factors` are the means of the grid's signals over each tick, `row` is the row of this tick."""


@dispatch_by_class
def begin_step(steps, grid, automata, seam, factors, row):
    """Begin a step of the automata: half a kick, then the drift."""


@dispatch_by_class
def end_step(steps, grid, automata, seam, tick, has_next_tick):
    """End a step of the automata with half a kick by the forces at the new positions, which must have been computed.

    `tick` is the number at the end of this tick; `has_next_tick` says whether another one follows in this call.

    Returns:
        The number of an inverted cell, or -1.
    """


@dispatch_by_class
def end_tick(steps, grid, automata, seam, factors, row, tick, has_next_tick):
    """End a tick; return the number of an inverted cell, or -1."""


@spliced
def kick_and_drift_automata(automata, interface, state, time):
    """Begin a step of the automata after the interface nodes have drifted: half a kick, then the drift."""
    kick_automata(automata, 0.5 * time)
    drift(automata.motion, time)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)


# -- lockstep -------------------------------------------------------------------------------------------------------------


@begin_tick.register(Lockstep)
def _begin_tick_in_lockstep(steps, grid, automata, seam, factors, row):
    return None


@begin_step.register(Lockstep)
def _begin_step_in_lockstep(steps, grid, automata, seam, factors, row):
    interface, exchange, half = seam.interface, seam.exchange, 0.5 * steps.step
    save_tick_start(automata.edges, automata.motion, automata.scratch.cells)
    copy_interface_rows(interface.nodes, grid.state.velocity, exchange.before)
    kick_and_drift_grid(grid, factors, row, steps.step)
    tally_kick(seam, grid.state.velocity, grid.conditions, half, half)
    kick_and_drift_automata(automata, interface, grid.state, steps.step)


@end_step.register(Lockstep)
def _end_step_in_lockstep(steps, grid, automata, seam, tick, has_next_tick):
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    failed = finish_cells(grid, seam, steps.step, tick, has_next_tick)
    assemble_interface_forces(seam, state, grid.conditions, half, steps.by_momentum)
    copy_interface_rows(interface.nodes, state.velocity, exchange.before)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    tally_kick(seam, state.velocity, grid.conditions, half, half)
    kick_automata(automata, half)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)
    tally_edges(automata.edges, automata.body.cells, automata.motion, automata.scratch.cells, steps.step)
    return failed


@end_tick.register(Lockstep)
def _end_tick_in_lockstep(steps, grid, automata, seam, factors, row, tick, has_next_tick):
    return -1


# -- impulses -------------------------------------------------------------------------------------------------------------


@begin_tick.register(Impulses)
def _begin_tick_with_impulses(steps, grid, automata, seam, factors, row):
    """Kick the grid nodes by the cell forces for half a step, and drift those outside the interface."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    copy_interface_rows(interface.nodes, state.displacement, exchange.start)
    copy_interface_rows(interface.nodes, state.velocity, exchange.before)
    kick_and_drift_grid(grid, factors, row, step)
    tally_kick(seam, state.velocity, grid.conditions, 0.5 * step, 0.0)
    begin_micro_steps(grid, seam)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)


@begin_step.register(Impulses)
def _begin_step_with_impulses(steps, grid, automata, seam, factors, row):
    time = steps.step / steps.micro
    save_tick_start(automata.edges, automata.motion, automata.scratch.cells)
    kick_nodes(grid, seam, 0.5 * time, steps.by_momentum)
    drift_nodes(grid, seam, time)
    kick_and_drift_automata(automata, seam.interface, grid.state, time)


@end_step.register(Impulses)
def _end_step_with_impulses(steps, grid, automata, seam, tick, has_next_tick):
    time = steps.step / steps.micro
    kick_nodes(grid, seam, 0.5 * time, steps.by_momentum)
    kick_automata(automata, 0.5 * time)
    move_interface_automata(seam.interface, automata.body.layout, grid.state.displacement, grid.state.velocity, automata.motion)
    tally_edges(automata.edges, automata.body.cells, automata.motion, automata.scratch.cells, time)
    return -1


@end_tick.register(Impulses)
def _end_tick_with_impulses(steps, grid, automata, seam, factors, row, tick, has_next_tick):
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    use_mean_velocities(grid, seam, steps.step)
    failed = finish_cells(grid, seam, steps.step, tick, has_next_tick)
    end_micro_steps(grid, seam)
    copy_interface_rows(interface.nodes, state.velocity, exchange.before)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    tally_kick(seam, state.velocity, grid.conditions, half, 0.0)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)
    return failed


@internal
def kick_nodes(grid, seam, time, by_momentum):
    """Kick the interface nodes with the forces of the automata for `time` [s]."""
    interface, exchange, conditions, velocity = seam.interface, seam.exchange, grid.conditions, grid.state.velocity
    copy_interface_rows(interface.nodes, grid.state.velocity, exchange.before)
    for row in range(interface.nodes.size):
        n, i = interface.nodes[row], exchange.places[row]
        carried = interface.mass[row]
        for k in range(2):
            force = exchange.automata_force[row, k]
            if conditions.prescribed[i, k]:
                exchange.given[row, k] += time * force
            else:
                velocity[n, k] = kicked_velocity(
                    velocity[n, k], time, 0.0, force, conditions.mass[i] - carried, carried, by_momentum
                )
    tally_kick(seam, grid.state.velocity, conditions, 0.0, time)


@internal
def begin_micro_steps(grid, seam):
    """Undo the drift of interface nodes in `kick_and_drift_grid`, because they drift with the micro-steps."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        for k in range(2):
            grid.state.displacement[n, k] = seam.exchange.start[row, k]
            seam.exchange.given[row, k] = 0.0


@internal
def drift_nodes(grid, seam, time):
    """Move the interface nodes for `time` [s] at their velocities."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        grid.state.displacement[n, 0] += time * grid.state.velocity[n, 0]
        grid.state.displacement[n, 1] += time * grid.state.velocity[n, 1]


@internal
def use_mean_velocities(grid, seam, step):
    """Give interface nodes their mean velocities over the tick, for the strains of cells; save the present velocities."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    for row in range(interface.nodes.size):
        n = interface.nodes[row]
        for k in range(2):
            exchange.before[row, k] = state.velocity[n, k]
            state.velocity[n, k] = (state.displacement[n, k] - exchange.start[row, k]) / step


@internal
def end_micro_steps(grid, seam):
    """Restore the velocities of interface nodes, from which `finish_conditions` continues.

    Along prescribed components the boundary supplies the impulse opposite to that of the automata.
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


# -- the paper's sub-steps ------------------------------------------------------------------------------------------------


@begin_tick.register(Literal)
def _begin_tick_literally(steps, grid, automata, seam, factors, row):
    """Set the sums of the forces of the automata on interface nodes to 0."""
    for node in range(seam.interface.nodes.size):
        seam.exchange.given[node, 0] = seam.exchange.given[node, 1] = 0.0


@begin_step.register(Literal)
def _begin_step_literally(steps, grid, automata, seam, factors, row):
    """Kick and drift the automata; interface automata move with the velocities of their nodes."""
    time = steps.step / steps.micro
    save_tick_start(automata.edges, automata.motion, automata.scratch.cells)
    kick_automata(automata, 0.5 * time)
    set_interface_velocities(seam.interface, automata.body.layout, grid.state.velocity, automata.motion)
    drift(automata.motion, time)


@end_step.register(Literal)
def _end_step_literally(steps, grid, automata, seam, tick, has_next_tick):
    """Add the forces on the nodes to their mean over the tick, and kick the automata."""
    exchange, time = seam.exchange, steps.step / steps.micro
    for node in range(seam.interface.nodes.size):
        exchange.given[node, 0] += exchange.automata_force[node, 0] / steps.micro
        exchange.given[node, 1] += exchange.automata_force[node, 1] / steps.micro
    kick_automata(automata, 0.5 * time)
    set_interface_velocities(seam.interface, automata.body.layout, grid.state.velocity, automata.motion)
    tally_edges(automata.edges, automata.body.cells, automata.motion, automata.scratch.cells, time)
    return -1


@end_tick.register(Literal)
def _end_tick_literally(steps, grid, automata, seam, factors, row, tick, has_next_tick):
    """Advance the grid by a tick, with the mean force of the automata on the interface nodes."""
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    for node in range(interface.nodes.size):
        for k in range(2):
            exchange.automata_force[node, k] = exchange.given[node, k]
    assemble_interface_forces(seam, state, grid.conditions, half, steps.by_momentum)
    kick_and_drift_grid(grid, factors, row, steps.step)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)
    failed = finish_cells(grid, seam, steps.step, tick, has_next_tick)
    assemble_interface_forces(seam, state, grid.conditions, half, steps.by_momentum)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    move_interface_automata(interface, automata.body.layout, state.displacement, state.velocity, automata.motion)
    return failed
