"""Loads (given forces) and grips (given velocities) of automata in a kick-drift-kick step, also of automata at the interface.

`automata.loads` uses steps that drift first. Here a load acts in both half kicks of a tick. Its work is force times the mean of
the velocities before and after the tick; with this definition the discrete energy of leapfrog balances to rounding.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.edge_conditions import Conditions
from ..automata.lattice import FORCE_X, FORCE_Y, INERTIA, MASS, SPIN, TORQUE, VX, VY, X, Y
from ..automata.loads import (
    ANGULAR_IMPULSE,
    HOLDS_ROTATION,
    HOLDS_X,
    HOLDS_Y,
    IMPULSE_X,
    IMPULSE_Y,
    WORK,
    Grip,
    Load,
    load_torque,
    save_velocities,
)
from ..errors import ParameterError
from ..grid import kernel_arrays
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray
from ..support.jit import internal
from .interface import Interface


class EdgeLoads(NamedTuple):
    """Loads and grips of the automata as the kernels of a coupled body apply them.

    Attributes:
        load: forces on automata outside the interface; 0 along directions with prescribed motion.
        grip: prescribed velocities.
        grip_place: scratch: displacements of gripped automata before the tick, shape (g, 2).
        grip_force: scratch: forces and torque on gripped automata before the tick, shape (g, 3).
        tallies: sums of work and impulse of loads and of grips, part of the state; see `automata.loads`.
    """

    load: Load
    grip: Grip
    grip_place: FloatArray
    grip_force: FloatArray
    tallies: FloatArray


@internal
def save_tick_start(edges, motion, forces):
    """Record the velocities and forces of loaded and gripped automata before the first half kick of a tick."""
    save_velocities(edges.load.place, motion, edges.load.before)
    save_velocities(edges.grip.place, motion, edges.grip.before)
    for row in range(edges.grip.place.size):
        p = edges.grip.place[row]
        edges.grip_place[row, 0], edges.grip_place[row, 1] = motion[X, p], motion[Y, p]
        edges.grip_force[row, 0], edges.grip_force[row, 1] = forces[FORCE_X, p], forces[FORCE_Y, p]
        edges.grip_force[row, 2] = forces[TORQUE, p]


@internal
def apply_loads_and_grips(edges, cells, motion, time):
    """Apply the loads for a half kick of `time` [s], tally the moment of their impulse, set velocities of gripped automata.

    `cells` are the `cells` of a `lattice.Body`.
    """
    load, grip = edges.load, edges.grip
    for row in range(load.place.size):
        p, fx, fy, turning = load.place[row], load.force[row, 0], load.force[row, 1], load_torque(load, row)
        motion[VX, p] += time / cells[MASS, p] * fx
        motion[VY, p] += time / cells[MASS, p] * fy
        motion[SPIN, p] += time / cells[INERTIA, p] * turning
        moment = (cells[X, p] + motion[X, p]) * fy - (cells[Y, p] + motion[Y, p]) * fx
        edges.tallies[0, ANGULAR_IMPULSE] += time * (moment + turning)
    for row in range(grip.place.size):
        p, held = grip.place[row], grip.held[row]
        if held & HOLDS_X:
            motion[VX, p] = grip.velocity[row, 0]
        if held & HOLDS_Y:
            motion[VY, p] = grip.velocity[row, 1]
        if held & HOLDS_ROTATION:
            motion[SPIN, p] = 0.0


@internal
def tally_edges(edges, cells, motion, forces, time):
    """Tally work and impulse of loads and grips over a whole tick of `time` [s]; `forces` are those at its end."""
    load, grip, old, tally = edges.load, edges.grip, edges.grip_force, edges.tallies[0]
    for row in range(load.place.size):
        p, fx, fy = load.place[row], load.force[row, 0], load.force[row, 1]
        mean_x, mean_y = 0.5 * (load.before[row, 0] + motion[VX, p]), 0.5 * (load.before[row, 1] + motion[VY, p])
        mean_spin = 0.5 * (load.before[row, 2] + motion[SPIN, p])
        tally[WORK] += time * (fx * mean_x + fy * mean_y + load_torque(load, row) * mean_spin)
        tally[IMPULSE_X] += time * fx
        tally[IMPULSE_Y] += time * fy
    tally = edges.tallies[1]
    for row in range(grip.place.size):
        p, held = grip.place[row], grip.held[row]
        x, y = cells[X, p] + motion[X, p], cells[Y, p] + motion[Y, p]
        if held & HOLDS_X:
            before, given, force = grip.before[row, 0], grip.velocity[row, 0], (old[row, 0], forces[FORCE_X, p])
            first, second = _tally_grip(cells[MASS, p], before, given, force, time, tally)
            tally[IMPULSE_X] += first + second
            tally[ANGULAR_IMPULSE] -= (cells[Y, p] + edges.grip_place[row, 1]) * first + y * second
        if held & HOLDS_Y:
            before, given, force = grip.before[row, 1], grip.velocity[row, 1], (old[row, 1], forces[FORCE_Y, p])
            first, second = _tally_grip(cells[MASS, p], before, given, force, time, tally)
            tally[IMPULSE_Y] += first + second
            tally[ANGULAR_IMPULSE] += (cells[X, p] + edges.grip_place[row, 0]) * first + x * second
        if held & HOLDS_ROTATION:
            spin, turned = grip.before[row, 2], 0.5 * time * (old[row, 2] + forces[TORQUE, p])
            tally[WORK] -= 0.5 * cells[INERTIA, p] * spin * spin
            tally[ANGULAR_IMPULSE] -= cells[INERTIA, p] * spin + turned


@internal
def _tally_grip(mass, before, prescribed, force, time, tally):
    """Add the work of a grip on one component to a tally; return its impulses in both halves of the tick [N s]."""
    old, new = force
    tally[WORK] += 0.5 * mass * (prescribed * prescribed - before * before) - 0.5 * time * prescribed * (old + new)
    return mass * (prescribed - before) - 0.5 * time * old, -0.5 * time * new


class EdgeInputs:
    """Loads and grips of the automata. Loads on interface automata are passed to their nodes.

    Attributes:
        edges: the `EdgeLoads` for kernels; for interface automata only the rotation can be prescribed.
    """

    def __init__(self, conditions: Conditions, interface: Interface, tallies: FloatArray) -> None:
        """Build from the conditions of the automata, the interface and the tallies."""
        load, grip, free = conditions.load, conditions.grip, interface.free > 0
        self._conditions, self._interface = conditions, interface
        self._loads = np.flatnonzero(free[load.automata])
        held = np.where(free[grip.automata], grip.held, grip.held & HOLDS_ROTATION)
        some = len(self._loads)
        bits = np.zeros(len(free), dtype=np.int64)
        bits[grip.automata] = held
        self._acts = np.stack([bits & HOLDS_X, bits & HOLDS_Y], axis=1)[load.automata[self._loads]] == 0
        kept, count = self._loads, len(grip.automata)
        self.edges = EdgeLoads(
            Load(load.automata[kept], load.place[kept], np.zeros((some, 2)), load.lever[kept], np.zeros((some, 3))),
            grip._replace(held=held), np.zeros((count, 2)), np.zeros((count, 3)), tallies,
        )  # fmt: skip

    def fill_loads(self) -> None:
        """Copy the current loads from the conditions of the automata; components with prescribed motion get no load."""
        self.edges.load.force[:] = np.where(self._acts, self._conditions.load.force[self._loads], 0.0)

    def loads_on_nodes(self, conditions: kernel_arrays.Conditions, places: IntArray) -> FloatArray | None:
        """Return nodal forces by loads on interface automata, shape (nodes with conditions, 2) [N]; None without such loads.

        Args:
            conditions: the `Conditions` of the grid.
            places: row of each interface node in `conditions`.
        """
        load, interface = self._conditions.load, self._interface
        if len(self._loads) == len(load.automata):
            return None
        pulled = np.zeros((len(interface.free), 2))
        np.add.at(pulled, load.automata, load.force)
        found = np.zeros((len(conditions.nodes), 2))
        rows = np.repeat(places, np.diff(interface.first))
        np.add.at(found, rows, interface.shares[:, None] * pulled[interface.automata[interface.acting]])
        return np.where(conditions.prescribed > 0, 0.0, found)

    def refuse_free_nodes(self, mesh: Mesh, conditions: kernel_arrays.Conditions) -> None:
        """Refuse interface automata whose motion an edge prescribes while their nodes are free.

        Raises:
            ParameterError: names the automaton and the node.
        """
        grip, interface = self._conditions.grip, self._interface
        row_of = {int(node): row for row, node in enumerate(conditions.nodes)}
        ends = dict(zip(interface.automata.tolist(), interface.ends.tolist(), strict=True))
        for automaton, held in zip(grip.automata.tolist(), grip.held.tolist(), strict=True):
            for node in ends.get(automaton, ()):
                for k, bit in enumerate((HOLDS_X, HOLDS_Y)):
                    if held & bit and not conditions.prescribed[row_of[node], k]:
                        x, y = mesh.nodes[node]
                        raise ParameterError(
                            f"the motion of automaton {automaton} on the interface, at ({x:.9g}, {y:.9g}) m, is prescribed "
                            f"along {'xy'[k]}, but node {node} of the grid is free there",
                            hint="give the edge of the grid that ends there the same condition",
                            at="automata",
                        )
