"""Lockstep: one step of the automata in a tick; an interface node feels the sum of both forces, m a = F."""

from __future__ import annotations

from ..grid import kernels as grid_kernels
from ..support.jit import internal
from .applied_loads import keep_before
from .exchange import assemble, follow, keep_velocities, settle_kick
from .kicks_and_drifts import begin_automata, begin_grid, finish_automata, settle_edges


@internal
def move_together(grid, automata, seam, factors, row, steps):
    """Kick for half a step and drift."""
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    keep_before(automata.edges, automata.motion, automata.scratch.force, automata.scratch.torque)
    keep_velocities(interface, exchange, state)
    begin_grid(grid, factors, row, steps.step)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    begin_automata(automata, seam, state, steps, steps.step, row == 0)


@internal
def finish_together(grid, automata, seam, steps):
    """Kick for the second half of a step, all forces being there; return the largest squared speed of automata."""
    interface, exchange, state, half = seam.interface, seam.exchange, grid.state, 0.5 * steps.step
    assemble(interface, exchange, state, grid.conditions, half, steps.by_momentum)
    keep_velocities(interface, exchange, state)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    settle_kick(interface, exchange, state, grid.conditions, half, half)
    fastest = finish_automata(automata, steps, steps.step)
    follow(interface, state, automata.motion)
    settle_edges(automata, steps.step)
    return fastest
