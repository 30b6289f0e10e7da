"""The steps and readings of a specimen all of whose pairs stay linked and elastic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..events import EventDetail
from ..state_block import Block, Layout
from ..support.float_arrays import FloatArray
from .elastic_energy import elastic_energy
from .kernel_arrays import Body, Motion, Scratch
from .linked_steps import advance
from .linked_sweep import KEPT, update_forces
from .loads_and_grips import Conditions
from .packing import Packing
from .pair import largest_strain, orient
from .stress import stresses
from .sweep_order import Part, make_part


class LinkedSpecimen:
    """A specimen without histories: the fast path.

    Attributes:
        fields: its own parts of the state.
        growing: its own lists in the state.
        event_kinds: what can happen.
        event_details: units of these, and what their indices count.
        whole: the order of the work.
    """

    fields: Layout = {}
    growing: Layout = {}
    event_kinds: Mapping[str, str] = {}
    event_details: Mapping[str, EventDetail] = {}

    def __init__(
        self, packing: Packing, body: Body, conditions: Conditions, scratch: Scratch, step: float, limit: float
    ) -> None:
        """Take what there is: the packing, what it is made of, inputs, scratch, the step [s] and the speed limit [m/s]."""
        self.packing, self.body, self.conditions, self.scratch = packing, body, conditions, scratch
        self.step_size, self.speed_limit = step, limit
        self.count = len(packing.kind)
        self._links = len(packing.pairs())
        self._prepare_sweeps()

    def _prepare_sweeps(self) -> None:
        """Make the order of the work, through the automata."""
        self.whole: Part = make_part(self.body)
        self._kept = np.zeros((len(self.conditions.marked), KEPT))

    def bind(self, block: Block) -> None:
        """Take the state."""
        self.motion = Motion(*(block[name] for name in Motion._fields))
        self.tallies = block["tallies"]

    def start(self) -> None:
        """Write the start of its own parts of the state."""

    def advance(self, tick: int, ticks: int) -> int:
        """Advance from a tick with the loads and velocities that the conditions have now; 0, or a status."""
        return advance(self.body, self.whole, *self.arguments(ticks))

    def arguments(self, ticks: int) -> tuple[Any, ...]:
        """Return what `linked_steps.advance` takes beside a body and a part."""
        inputs = self.conditions
        return (
            self.packing.reference, self.motion, self.scratch, inputs.marked, self._kept, inputs.load, inputs.load_before,
            inputs.grip, inputs.grip_before, self.tallies, self.step_size, ticks, self.speed_limit,
        )  # fmt: skip

    def dilation(self) -> FloatArray:
        """Compute the rotations and volumetric strains of the present state; return the strains, in the scratch."""
        return self._strain(self.motion)

    def _strain(self, motion: Motion) -> FloatArray:
        scratch = self.scratch
        orient(motion.rotation, scratch.half, 0, self.count)
        update_forces(self.body, self.whole, motion, scratch)
        return scratch.dilation

    def forces(self) -> FloatArray:
        """Return the forces of links and contacts in the present state, shape (n, 2) [N]."""
        self.dilation()
        return self.scratch.force

    def stress(self) -> FloatArray:
        """Return the stresses of the automata, shape (n, 3) [Pa]."""
        found, theta = np.empty((self.count, 3)), self.dilation()
        u, half = self.motion.displacement, self.scratch.half
        stresses(self.body, u, half, theta, found, 0, self.count)
        return found

    def linked(self) -> FloatArray:
        """Return the weight of each link."""
        return np.ones(self._links)

    def broken_links(self) -> float:
        """Return how many links are broken."""
        return 0.0

    def touching(self) -> float:
        """Return how many contacts press."""
        return 0.0

    def damage(self) -> FloatArray:
        """Return what part of the faces of each automaton is broken, shape (n,)."""
        return np.zeros(self.count)

    def stored(self, since: float) -> dict[str, float]:
        """Return the energies that are stored, but those of motion [J]; the forces were computed last so long ago [s]."""
        return self._energies(self.motion, since)

    def mean_energy(self, time: float) -> float:
        """Return the mean of the energies that are stored a time [s] before and after, as the velocities are now [J].

        The forces were computed last at that time before.
        """
        u, v, rotation, spin = self.motion
        before, after = (Motion(u + way * v, v, rotation + way * spin, spin) for way in (-time, time))
        return 0.5 * (sum(self._energies(before, 0.0).values()) + sum(self._energies(after, 2.0 * time).values()))

    def _energies(self, motion: Motion, since: float) -> dict[str, float]:
        """Return the energies that a motion stores [J]; its rotations stay in the scratch."""
        theta, u, half = self._strain(motion), motion.displacement, self.scratch.half
        found = elastic_energy(self.body, u, half, theta, 0, self.count)
        return {"elastic_energy": found}

    def report(self) -> dict[str, float]:
        """Return how far links are strained."""
        return {"largest strain of a link now": self._largest_strain()}

    def _largest_strain(self) -> float:
        orient(self.motion.rotation, self.scratch.half, 0, self.count)
        return float(largest_strain(self.body, self.motion.displacement, self.scratch.half))

    def lost(self) -> dict[str, float]:
        """Return the energies that were lost [J]."""
        return {}
