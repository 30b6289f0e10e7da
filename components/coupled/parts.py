"""The two parts of a coupled medium as kernel arguments, and the kicks and drifts that all schemes share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.contacts import Contacts
from ..automata.kernels import Specimen, write_forces
from ..automata.lattice import Body, Motion, Scratch, update_ghost_velocities
from ..automata.linked_specimen import write_link_forces
from ..automata.loads import kick
from ..grid import kernels as grid_kernels
from ..grid.kernel_arrays import Conditions, Grid, State, Yields
from ..support.float_arrays import FloatArray
from ..support.jit import internal, spliced
from .edge_loads import EdgeLoads, apply_loads_and_grips
from .exchange import Exchange, copy_interface_rows, gather_forces
from .interface import Interface
from .side_contacts import Sides

# numba gives a literal 0 another type, and would compile the grid kernels a second time for it.
_ZERO = np.int64(0)


class GridPart(NamedTuple):
    """The grid, its state, its nodes with conditions, scratch, the tally of their work, and the buffer of yield events."""

    grid: Grid
    state: State
    conditions: Conditions
    corner: FloatArray
    tally: FloatArray
    yields: Yields


class AutomataPart(NamedTuple):
    """The automata on their lattice.

    Attributes:
        body: centres in the coordinates of the grid. Interface automata have infinite mass, because they
            follow their nodes instead of forces; they rotate freely.
        motion: displacements, velocities and rotations, see `lattice.Motion`.
        scratch: results of a force evaluation, see `lattice.Scratch`.
        edges: loads and grips, see `edge_loads.EdgeLoads`.
    """

    body: Body
    motion: Motion
    scratch: Scratch
    edges: EdgeLoads


class CrackingPart(NamedTuple):
    """The histories and contacts of automata that break or yield; None where automata stay linked and elastic.

    Attributes:
        specimen: an `automata.kernels.Specimen` with the same motion and scratch.
        contacts: the `contacts.Contacts` of the state.
        travel_limit: distance that the fastest automaton may move before contacts are searched again [m].
        sides: free sides of the grid that automata can touch; None without side contacts.
    """

    specimen: Specimen
    contacts: Contacts
    travel_limit: float
    sides: Sides | None


class Seam(NamedTuple):
    """The interface for kernels: which nodes move with which automata, and the forces and work that they exchange."""

    interface: Interface
    exchange: Exchange


# -- the automata ---------------------------------------------------------------------------------------------------------


@spliced
def update_automata_forces(automata, linked_body, cracking, seam, time, tick):
    """Write the forces and torques of links and contacts, and the forces of the automata on interface nodes.

    The links of `cracking` have been checked; it is None for automata that stay linked and elastic, `linked_body` is None for
    others. `time` is the time since the forces were last computed [s], `tick` the number of the step of the automata.
    """
    if linked_body is not None:
        write_link_forces(linked_body, automata.motion, automata.scratch)
    if cracking is not None:
        write_forces(cracking.specimen, cracking.contacts, time, tick)
    gather_forces(seam.interface, automata.body.layout.place, automata.scratch.cells, seam.exchange.automata_force)


@internal
def kick_automata(automata, time):
    """Kick all automata by their forces and loads, then set the velocities of gripped automata."""
    kick(automata.body, automata.motion, automata.scratch.cells, time)
    apply_loads_and_grips(automata.edges, automata.body.cells, automata.motion, time)
    update_ghost_velocities(automata.body.layout.ghosts, automata.motion)


# -- the grid -------------------------------------------------------------------------------------------------------------


@spliced
def kick_and_drift_grid(grid, factors, row, step):
    """Kick all nodes for half a step and drift them for a whole one, unless `finish_cells` has already done so."""
    if row == 0:
        count = len(grid.grid.reference)
        grid_kernels.kick(grid.grid, grid.state, step, _ZERO, count)
        grid_kernels.drift(grid.grid, grid.state, step, _ZERO, count)
    grid_kernels.begin_conditions(grid.grid, grid.state, grid.conditions, factors, row, step)


@spliced
def finish_cells(grid, seam, step, tick, has_next_tick):
    """Advance the cells, kick the nodes without conditions, and complete the forces on the other nodes.

    `step` is the internal step [s], `tick` the number at the end of this tick. If another tick follows in this call, nodes
    without conditions begin it at once.

    Returns:
        The number of an inverted cell, or -1.
    """
    cells, nodes = len(grid.grid.cells), len(grid.grid.reference)
    failed = grid_kernels.advance_cells(grid.grid, grid.state, grid.corner, step, tick, grid.yields, _ZERO, cells)
    grid_kernels.finish_nodes(grid.grid, grid.state, grid.corner, step, has_next_tick, _ZERO, nodes)
    grid_kernels.finish_forces(grid.grid, grid.state, grid.conditions.groups, grid.corner)
    copy_interface_rows(seam.interface.nodes, grid.state.force, seam.exchange.grid_force)
    return failed
