"""A specimen all of whose pairs stay linked and elastic: its forces, its internal steps, its readings.

    theta_i = sum_j c_ij eps_ij / (1 + c* lambda / 2 G),        c_ij = S r / 2 V
    f_n = S (2 G eps + lambda (theta_i + theta_j) / 2),         f_t = S 2 G gamma
    U = sum over pairs S r G (eps^2 + gamma^2) + sum over automata (1/2) V lambda (1 + c* lambda / 2 G) theta^2

c* is the share of the free faces of a whole cell: they carry no traction, 2 G eps* + lambda theta = 0, and move accordingly.
K and G are exact for a homogeneous strain, for both packings. See `pair` for the strains and the forces.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..events import EventDetail
from ..state_block import Block, Layout
from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .edges import Conditions
from .lattice import Body, Motion, Scratch, load, make_motion, make_scratch, store, update_ghost_velocities, update_ghosts
from .loads import Inputs, count_fast, drift, kick_with_inputs, momenta
from .packing import Packing
from .pair import dilate, strain_links, sum_forces, sum_shares, virial

# What `advance` returns.
DONE, TOO_FAST = 0, 1


@internal
def link_forces(body, motion, scratch):
    """Write the volumetric strains of the positions as they are, and the forces and torques of the links.

    Args:
        body: a `lattice.Body` of one material.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`, overwritten.
    """
    links, forces, theta = scratch.links, scratch.forces, scratch.forces.dilation
    strain_links(body, motion, scratch)
    dilate(body, links.eps, scratch)
    update_ghosts(body.layout, theta)
    begin = body.layout.begin
    twice, half = 2.0 * body.shear[begin], 0.5 * body.lame[begin]
    for q in range(body.layout.offset.size):
        o = body.layout.offset[q]
        end = theta.size - o
        strains, direction = (links.eps[q, :end], links.gamma[q, :end]), (links.ex[q, :end], links.ey[q, :end])
        pulls = (links.first[q, :end], links.second[q, :end], links.torque[q, :end])
        _pull(strains, direction, theta[:end], theta[o:], body.face[q, :end], (twice, half), pulls)
    sum_forces(body, links, forces)


@internal
def _pull(strains, direction, theta_i, theta_j, face, moduli, pulls):
    """Write the forces and torques of links; those on the second automaton are the opposite forces, and the same torques."""
    (eps, gamma), (ex, ey), (twice_shear, half_lame), (fx, fy, torque) = strains, direction, moduli, pulls
    for p in range(eps.size):
        stiffness, pressing = face[p] * twice_shear, (face[p] * half_lame) * (theta_i[p] + theta_j[p])
        fn, ft = stiffness * eps[p] + pressing, stiffness * gamma[p]
        fx[p], fy[p] = fn * ex[p] - ft * ey[p], fn * ey[p] + ft * ex[p]
        # (1 + eps) ft - gamma fn, without what cancels.
        torque[p] = ft - gamma[p] * pressing


@jit
def update_forces(body, motion, scratch):
    """Call `link_forces` from Python."""
    link_forces(body, motion, scratch)


@jit
def advance(body, motion, scratch, inputs, time, ticks, speed_limit):
    """Advance by internal steps: half a drift, a kick, half a drift (leapfrog, second order).

    Args:
        body: a `lattice.Body`.
        motion: a `lattice.Motion`, updated in place.
        scratch: a `lattice.Scratch`, overwritten.
        inputs: `loads.Inputs`; the tallies are updated.
        time: length of a step [s].
        ticks: number of steps.
        speed_limit: no automaton may be faster [m/s].

    Returns:
        DONE, or TOO_FAST in the middle of a step.
    """
    for _ in range(ticks):
        drift(motion, 0.5 * time)
        link_forces(body, motion, scratch)
        kick_with_inputs(body, motion, scratch.forces, inputs, time)
        update_ghost_velocities(body.layout, motion)
        drift(motion, 0.5 * time)
        if count_fast(motion, speed_limit * speed_limit):
            return TOO_FAST
    return DONE


@jit
def elastic_energy(body, scratch):
    """Return the energy of links and volumes [J], for the strains in the scratch."""
    links, forces, total = scratch.links, scratch.forces, 0.0
    for i in range(body.layout.place.size):
        p, squares = body.layout.place[i], 0.0
        for q in range(body.layout.offset.size):
            squares += body.face[q, p] * (links.eps[q, p] * links.eps[q, p] + links.gamma[q, p] * links.gamma[q, p])
        total += body.diameter * body.shear[p] * squares
        total += 0.5 * body.volume[p] * body.lame[p] / forces.stiffening[p] * forces.dilation[p] * forces.dilation[p]
    return total


@jit
def largest_strain(body, scratch):
    """Return the largest strain along or across a link."""
    largest = 0.0
    for q in range(body.layout.offset.size):
        for p in range(body.face.shape[1]):
            if body.face[q, p] > 0.0:
                largest = max(largest, abs(scratch.links.eps[q, p]), abs(scratch.links.gamma[q, p]))
    return largest


@jit
def stresses(body, scratch, found):
    """Write the stresses xx, yy and xy of all places, tension positive, shape (3, m) [Pa]: sigma = (1 / 2 V) sum r n F."""
    links, theta = scratch.links, scratch.forces.dilation
    begin, traction = body.layout.begin, np.zeros(body.face.shape)
    for component in range(3):
        for q in range(body.layout.offset.size):
            for p in range(theta.size - body.layout.offset[q]):
                pressing = body.lame[begin] * (0.5 * (theta[p] + theta[p + body.layout.offset[q]]))
                twice = 2.0 * body.shear[begin]
                parts = virial(twice * links.eps[q, p] + pressing, twice * links.gamma[q, p], links.ex[q, p], links.ey[q, p])
                traction[q, p] = parts[component]
        sum_shares(body, traction, links, found[component])


class LinkedSpecimen:
    """A specimen without histories.

    Attributes:
        fields: its own parts of the state.
        growing: its own lists in the state.
        event_kinds: what can happen.
        event_details: units of these, and what their indices count.
    """

    fields: Layout = {}
    growing: Layout = {}
    event_kinds: Mapping[str, str] = {}
    event_details: Mapping[str, EventDetail] = {}

    def __init__(self, packing: Packing, body: Body, conditions: Conditions, step: float, limit: float) -> None:
        """Take the packing, what it is made of, the inputs, the step [s] and the speed limit [m/s]."""
        self.packing, self.body, self.conditions = packing, body, conditions
        self.scratch: Scratch = make_scratch(body)
        self.motion: Motion = make_motion(body.layout.size)
        self.step_size, self.speed_limit = step, limit
        self.place = body.layout.place
        self.count = len(self.place)
        self._pairs = packing.pairs()

    def bind(self, block: Block) -> None:
        """Take the state."""
        self._block = block
        self.inputs = Inputs(self.conditions.load, self.conditions.grip, block["tallies"])

    def start(self) -> None:
        """Write the initial histories."""

    def load(self) -> None:
        """Write the state to the fields."""
        block = self._block
        load(self.body.layout, block["displacement"], block["velocity"], block["rotation"], block["spin"], self.motion)

    def store(self) -> None:
        """Write the fields to the state."""
        block = self._block
        store(self.body.layout, block["displacement"], block["velocity"], block["rotation"], block["spin"], self.motion)

    def advance(self, tick: int, ticks: int) -> int:
        """Advance the fields from a tick with the loads and velocities that the conditions have now; return a status."""
        return advance(self.body, self.motion, self.scratch, self.inputs, self.step_size, ticks, self.speed_limit)

    def update_forces(self) -> None:
        """Write the strains and the forces of links and contacts of the present fields, for readings."""
        update_forces(self.body, self.motion, self.scratch)

    def _measure(self) -> None:
        self.load()
        self.update_forces()

    def dilation(self) -> FloatArray:
        """Return the volumetric strains, shape (n,)."""
        self._measure()
        return self.scratch.forces.dilation[self.place]

    def forces(self) -> FloatArray:
        """Return the forces of links and contacts, shape (n, 2) [N]."""
        self._measure()
        return np.stack([self.scratch.forces.x[self.place], self.scratch.forces.y[self.place]], axis=1)

    def torques(self) -> FloatArray:
        """Return the torques of links and contacts, shape (n,) [N m]."""
        self._measure()
        return self.scratch.forces.torque[self.place]

    def stress(self) -> FloatArray:
        """Return the stresses of the automata, shape (n, 3) [Pa]."""
        self._measure()
        found = np.zeros((3, self.body.layout.size))
        stresses(self.body, self.scratch, found)
        return np.ascontiguousarray(found[:, self.place].T)

    def momenta(self) -> FloatArray:
        """Return momentum, angular momentum, kinetic energies of translation and rotation, shape (5,)."""
        self.load()
        found = np.empty(5)
        momenta(self.body, self.motion, found)
        return found

    def linked(self) -> FloatArray:
        """Return the weight of each link."""
        return np.ones(len(self._pairs))

    def broken_links(self) -> float:
        """Return how many links are broken."""
        return 0.0

    def touching(self) -> float:
        """Return how many contacts press."""
        return 0.0

    def damage(self) -> FloatArray:
        """Return the broken part of the faces of each automaton, shape (n,)."""
        return np.zeros(self.count)

    def stored(self, since: float) -> dict[str, float]:
        """Return the stored energies without those of motion [J]; `since` is the time since the last force evaluation [s]."""
        self.load()
        return self.energies(since)

    def mean_energy(self, time: float) -> float:
        """Return the mean of the energies that are stored a time [s] before and after, as the velocities are now [J].

        The forces were computed last at that time before.
        """
        total = 0.0
        for way, since in ((-time, 0.0), (time, 2.0 * time)):
            self.load()
            for value, rate in zip(self.motion[:2] + self.motion[4:5], self.motion[2:4] + self.motion[5:], strict=True):
                value += way * rate
            total += sum(self.energies(since).values())
        return 0.5 * total

    def energies(self, since: float) -> dict[str, float]:
        """Return the energies that the present fields store [J]; contacts have slid for a time [s] since `slid` was noted."""
        update_forces(self.body, self.motion, self.scratch)
        return {"elastic_energy": elastic_energy(self.body, self.scratch)}

    def report(self) -> dict[str, float]:
        """Return how far links are strained."""
        self._measure()
        return {"largest strain of a link now": self._largest_strain()}

    def _largest_strain(self) -> float:
        return float(largest_strain(self.body, self.scratch))

    def lost(self) -> dict[str, float]:
        """Return the energies that were lost [J]."""
        return {}
