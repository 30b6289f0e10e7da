"""The steps and readings of a specimen all of whose pairs stay linked and elastic."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..snapshot import Block
from ..support.arrays import FloatArray
from .advance import advance
from .conditions import Conditions
from .linked import dilations, elastic_energy
from .packing import Packing
from .pair import orient
from .state import Body, Motion, Scratch
from .stress import stresses


class LinkedSteps:
    """A specimen without histories: the fast path.

    Attributes:
        fields: its own parts of the state.
        growing: its own lists in the state.
        event_kinds: what can happen.
    """

    fields: Mapping[str, tuple[str, tuple[int, ...]]] = {}
    growing: Mapping[str, tuple[str, tuple[int, ...]]] = {}
    event_kinds: Mapping[str, str] = {}

    def __init__(
        self, packing: Packing, body: Body, conditions: Conditions, scratch: Scratch, step: float, limit: float
    ) -> None:
        """Take what there is: the packing, what it is made of, inputs, scratch, the step [s] and the speed limit [m/s]."""
        self.packing, self.body, self.conditions, self.scratch = packing, body, conditions, scratch
        self.step_size, self.speed_limit = step, limit
        self.count = len(packing.kind)
        self._links = len(packing.pairs())

    def bind(self, block: Block) -> None:
        """Take the state."""
        self.motion = Motion(*(block[name] for name in Motion._fields))
        self.tallies = block["tallies"]

    def start(self) -> None:
        """Write the start of its own parts of the state."""

    def advance(self, tick: int, ticks: int) -> int:
        """Advance from a tick with the loads and velocities that the conditions have now; 0, or a status."""
        edge = self.conditions
        forces = edge.load, edge.load_before, edge.grip, edge.grip_before, self.tallies
        return advance(
            self.body, self.packing.reference, self.motion, self.scratch, *forces, self.step_size, ticks, self.speed_limit
        )

    def dilation(self) -> FloatArray:
        """Compute the rotations and volumetric strains of the present state; return the strains, in the scratch."""
        orient(self.motion.rotation, self.scratch.half, 0, self.count)
        dilations(self.body, self.motion.displacement, self.scratch.half, self.scratch.dilation, 0, self.count)
        return self.scratch.dilation

    def stress(self) -> FloatArray:
        """Return the stresses of the automata, shape (n, 3) [Pa]."""
        found, theta = np.empty((self.count, 3)), self.dilation()
        stresses(self.body, self.motion.displacement, self.scratch.half, theta, found, 0, self.count)
        return found

    def linked(self) -> FloatArray:
        """Return the weight of each link."""
        return np.ones(self._links)

    def stored(self, since: float) -> dict[str, float]:
        """Return the energies that are stored, but those of motion [J]; the forces were computed last so long ago [s]."""
        theta = self.dilation()
        found = elastic_energy(self.body, self.motion.displacement, self.scratch.half, theta, 0, self.count)
        return {"elastic_energy": found}

    def lost(self) -> dict[str, float]:
        """Return the energies that were lost [J]."""
        return {}
