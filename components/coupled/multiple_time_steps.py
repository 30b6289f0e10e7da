"""Reversible multiple time steps: impulses of the cells around several steps of the automata; the interface goes with these."""

from __future__ import annotations

from ..grid import kernels as grid_kernels
from ..grid.kernel_arrays import BOUNDARY_ANGULAR, BOUNDARY_IMPULSE, WORK
from ..support.jit import internal
from .applied_loads import keep_before
from .exchange import follow, keep_velocities, kicked, settle_kick
from .kicks_and_drifts import begin_automata, begin_grid, finish_automata, settle_edges


@internal
def kick_nodes(grid, seam, time, by_momentum):
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
                velocity[n, k] = kicked(velocity[n, k], time, 0.0, force, conditions.mass[i] - carried, carried, by_momentum)
    settle_kick(interface, exchange, grid.state, conditions, 0.0, time)


@internal
def begin_micro_steps(grid, seam):
    """Take back the drift of the interface nodes in `begin_grid`: they drift with the micro-steps."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        for k in range(2):
            grid.state.displacement[n, k] = seam.exchange.start[row, k]
            seam.exchange.given[row, k] = 0.0


@internal
def keep_displacements(grid, seam):
    """Note where the interface nodes are at the begin of a tick."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        seam.exchange.start[row, 0], seam.exchange.start[row, 1] = grid.state.displacement[n, 0], grid.state.displacement[n, 1]


@internal
def drift_nodes(grid, seam, time):
    """Move the interface nodes with their velocities for `time` [s]."""
    for row in range(seam.interface.nodes.size):
        n = seam.interface.nodes[row]
        grid.state.displacement[n, 0] += time * grid.state.velocity[n, 0]
        grid.state.displacement[n, 1] += time * grid.state.velocity[n, 1]


@internal
def begin_impulses(grid, automata, seam, factors, row, steps):
    """Let the cells kick for half a step, and drift the nodes of the grid alone."""
    interface, exchange, state, step = seam.interface, seam.exchange, grid.state, steps.step
    keep_displacements(grid, seam)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, step)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    begin_micro_steps(grid, seam)
    follow(interface, state, automata.motion)


@internal
def move_with_impulses(grid, automata, seam, steps, time, first):
    """Let the automata kick for half a micro-step of `time` [s], and drift; `first` as for `begin_automata`."""
    keep_before(automata.edges, automata.motion, automata.scratch.force, automata.scratch.torque)
    kick_nodes(grid, seam, 0.5 * time, steps.by_momentum)
    drift_nodes(grid, seam, time)
    begin_automata(automata, seam, grid.state, steps, time, first)


@internal
def act_with_impulses(grid, automata, seam, steps, time):
    """Let the automata kick for the second half of a micro-step; return their largest squared speed."""
    kick_nodes(grid, seam, 0.5 * time, steps.by_momentum)
    fastest = finish_automata(automata, steps, time)
    follow(seam.interface, grid.state, automata.motion)
    settle_edges(automata, time)
    return fastest


@internal
def use_mean_velocities(grid, seam, step):
    """Give the interface nodes the mean velocities of the tick, for the strains of the cells; note the present ones."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    for row in range(interface.nodes.size):
        n = interface.nodes[row]
        for k in range(2):
            exchange.before[row, k] = state.velocity[n, k]
            state.velocity[n, k] = (state.displacement[n, k] - exchange.start[row, k]) / step


@internal
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


@internal
def finish_impulses(grid, automata, seam, step):
    """Let the cells, which have been advanced, kick for the second half of a step."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    end_micro_steps(grid, seam)
    keep_velocities(interface, exchange, state)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, step, grid.tally)
    settle_kick(interface, exchange, state, grid.conditions, 0.5 * step, 0.0)
    follow(interface, state, automata.motion)
