"""Inputs of the automata in a coupled body: which loads and grips stay with automata, and which pass to interface nodes."""

from __future__ import annotations

import numpy as np

from ..automata.loads_and_grips import Conditions
from ..automata.motion import HOLDS_ROTATION, HOLDS_X, HOLDS_Y, Grip, Load
from ..errors import ParameterError
from ..grid import kernel_arrays
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray
from .applied_loads import Edges
from .interface import Interface


class EdgeInputs:
    """Loads and held automata: those of the interface move with their nodes, which get the loads on them.

    Attributes:
        edges: what kernels take; of automata of the interface the rotation alone is held.
    """

    def __init__(self, conditions: Conditions, interface: Interface) -> None:
        """Take what the automata have by themselves, and which of them the interface carries."""
        load, grip, free = conditions.load, conditions.grip, interface.free > 0
        self._conditions, self._interface = conditions, interface
        self._loads = np.flatnonzero(free[load.automata])
        held = np.where(free[grip.automata], grip.held, grip.held & HOLDS_ROTATION)
        some, rows = len(self._loads), len(grip.automata)
        bits = np.zeros(len(free), dtype=np.int64)
        bits[grip.automata] = held
        self._acts = np.stack([bits & HOLDS_X, bits & HOLDS_Y], axis=1)[load.automata[self._loads]] == 0
        self.edges = Edges(
            Load(load.automata[self._loads], np.zeros((some, 2)), load.lever[self._loads]),
            Grip(grip.automata, held, grip.velocity),
            np.zeros((some, 3)), np.zeros((rows, 5)), np.zeros((rows, 3)),
        )  # fmt: skip

    def fill_loads(self) -> None:
        """Take the loads that the conditions of the automata have now; what is held feels none."""
        self.edges.load.force[:] = np.where(self._acts, self._conditions.load.force[self._loads], 0.0)

    def loads_on_nodes(self, conditions: kernel_arrays.Conditions, places: IntArray) -> FloatArray | None:
        """Return what loads on automata of the interface give the nodes, shape (nodes with conditions, 2) [N]; None without.

        Args:
            conditions: of the grid.
            places: row of each interface node in these.
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
        """Refuse automata of the interface that an edge holds and their nodes do not.

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
                            f"automaton {automaton} at ({x:.9g}, {y:.9g}) m is held along {'xy'[k]} by its edge, and belongs "
                            f"to the interface, but node {node} of the grid is free there",
                            hint="give the edge of the grid that ends there the same condition",
                            at="automata",
                        )
