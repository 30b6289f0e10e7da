"""The sub-steps of Psakhie et al. as written (section 2.3, steps 2 to 4), which are unstable.

The automata make their steps first, those of the interface with the velocity that the nodes had; then the nodes feel the mean
of the forces of the automata, and take the automata along.
"""

from __future__ import annotations

import numpy as np

from ..automata import motion as automata_motion
from ..grid import kernels as grid_kernels
from ..support.jit import internal
from .applied_loads import keep_before
from .exchange import assemble, follow, hang
from .kicks_and_drifts import begin_grid, finish_cells, kick_automata, settle_edges


@internal
def begin_literally(seam):
    """Forget the forces of the last tick."""
    for row in range(seam.interface.nodes.size):
        seam.exchange.given[row, 0] = seam.exchange.given[row, 1] = 0.0


@internal
def move_literally(grid, automata, seam, time):
    """Kick and drift the automata for `time` [s]; those of the interface with the velocities of their nodes."""
    keep_before(automata.edges, automata.motion, automata.scratch.force, automata.scratch.torque)
    kick_automata(automata, 0.5 * time, np.inf)
    follow_velocities(seam.interface, grid.state, automata.motion)
    automata_motion.drift(automata.motion, time, 0, automata.body.kind.size)


@internal
def act_literally(grid, automata, seam, time, micro, limit):
    """Add to the mean of the forces, and kick the automata; return their largest squared speed."""
    exchange = seam.exchange
    for row in range(seam.interface.nodes.size):
        exchange.given[row, 0] += exchange.automata_force[row, 0] / micro
        exchange.given[row, 1] += exchange.automata_force[row, 1] / micro
    fastest = kick_automata(automata, 0.5 * time, limit)
    follow_velocities(seam.interface, grid.state, automata.motion)
    settle_edges(automata, time)
    return fastest


@internal
def finish_literally(grid, automata, seam, factors, row, steps, tick, again):
    """Advance the grid with the mean of the forces of the automata; return a cell that is inverted, or -1."""
    interface, exchange, state = seam.interface, seam.exchange, grid.state
    for node in range(interface.nodes.size):
        for k in range(2):
            exchange.automata_force[node, k] = exchange.given[node, k]
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.by_momentum)
    begin_grid(grid, factors, row, steps.step)
    follow(interface, state, automata.motion)
    failed = finish_cells(grid, seam, steps.step, tick, again)
    assemble(interface, exchange, state, grid.conditions, 0.5 * steps.step, steps.by_momentum)
    grid_kernels.finish_conditions(grid.grid, state, grid.conditions, steps.step, grid.tally)
    follow(interface, state, automata.motion)
    return failed


@internal
def follow_velocities(interface, state, motion):
    """Give the automata of the interface the velocities of their nodes, and leave them where they are."""
    hang(interface, state.velocity, motion.velocity)
