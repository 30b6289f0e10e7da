"""A specimen whose pairs all stay linked and elastic: forces, internal steps, outputs.

    theta_i = sum_j c_ij eps_ij / (1 + c* lambda / 2 G),        c_ij = S r / 2 V
    f_n = S (2 G eps + lambda (theta_i + theta_j) / 2),         f_t = S 2 G gamma
    U = sum over pairs S r G (eps^2 + gamma^2) + sum over automata (1/2) V lambda (1 + c* lambda / 2 G) theta^2

eps, gamma: see `pair_strains`; theta: volume strain; S: face area; r: distance of centres; V: cell volume; c*: sum of c over
the free faces of a cell, which carry no traction: 2 G eps* + lambda theta = 0. K and G are exact for a homogeneous strain.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..events import EventDetail
from ..state_block import Block, Layout
from ..support.float_arrays import FloatArray, ordered_sum
from ..support.jit import internal, jit
from .edge_conditions import Conditions
from .lattice import (
    DILATION,
    EPS,
    EX,
    EY,
    FACE,
    FIRST_TERM,
    FORCE_X,
    FORCE_Y,
    GAMMA,
    INERTIA,
    LAME,
    MASS,
    SECOND_TERM,
    SHEAR,
    STIFFENING,
    TORQUE,
    TURNING,
    VOLUME,
    VX,
    Body,
    Motion,
    Scratch,
    X,
    Y,
    load_motion,
    make_motion,
    make_scratch,
    store_motion,
    update_ghost_velocities,
    update_ghosts,
)
from .loads import Inputs, count_fast_automata, drift, kick_with_inputs
from .packing import Packing
from .pair_strains import sum_by_shares, sum_link_forces, virial_stress, write_link_strains

# Results of `advance`.
DONE, TOO_FAST = 0, 1


@internal
def write_link_forces(body, motion, scratch):
    """Write volumetric strains at the present positions, and forces and torques of the links, of a body of one material."""
    layout, links, cells = body.layout, scratch.links, scratch.cells
    write_link_strains(body, motion, scratch)
    sum_by_shares(body, links[EPS], links, cells[DILATION])
    for p in range(cells.shape[1]):
        cells[DILATION, p] *= cells[STIFFENING, p]
    update_ghosts(layout.ghosts, cells[DILATION])
    twice_shear, half_lame = 2.0 * body.cells[SHEAR, layout.begin], 0.5 * body.cells[LAME, layout.begin]
    for q in range(layout.offset.size):
        theta_j = cells[DILATION, layout.offset[q] :]
        for p in range(theta_j.size):
            area, eps, gamma, ex, ey = (
                body.links[FACE, q, p],
                links[EPS, q, p],
                links[GAMMA, q, p],
                links[EX, q, p],
                links[EY, q, p],
            )
            stiffness, pressing = area * twice_shear, (area * half_lame) * (cells[DILATION, p] + theta_j[p])
            fn, ft = stiffness * eps + pressing, stiffness * gamma
            links[FIRST_TERM, q, p], links[SECOND_TERM, q, p] = fn * ex - ft * ey, fn * ey + ft * ex
            # This is (1 + eps) ft - gamma fn, without the terms that cancel.
            links[TURNING, q, p] = ft - gamma * pressing
    sum_link_forces(body, links, cells)


@jit
def update_forces(body, motion, scratch):
    """Call the kernel `write_link_forces` from Python."""
    write_link_forces(body, motion, scratch)


@jit
def advance(body, motion, scratch, inputs, time, ticks, speed_limit):
    """Advance by internal steps: half a drift, a kick, half a drift (leapfrog, second order).

    `time` is the length of a step [s], `speed_limit` the largest speed of an automaton [m/s]; the tallies of `inputs` are
    updated.

    Returns:
        DONE, or TOO_FAST in the middle of a step.
    """
    for _ in range(ticks):
        drift(motion, 0.5 * time)
        write_link_forces(body, motion, scratch)
        kick_with_inputs(body, motion, scratch.cells, inputs, time)
        update_ghost_velocities(body.layout.ghosts, motion)
        drift(motion, 0.5 * time)
        if count_fast_automata(motion, speed_limit * speed_limit):
            return TOO_FAST
    return DONE


def elastic_energy(body: Body, scratch: Scratch) -> float:
    """Return the energy of links and volumes for the strains in the scratch [J]."""
    place = body.layout.place
    eps, gamma, face = scratch.links[EPS][:, place], scratch.links[GAMMA][:, place], body.links[FACE][:, place]
    of_links = body.diameter * body.cells[SHEAR, place] * (face * (eps * eps + gamma * gamma)).cumsum(axis=0)[-1]
    theta, stiffening = scratch.cells[DILATION, place], scratch.cells[STIFFENING, place]
    of_volumes = 0.5 * body.cells[VOLUME, place] * body.cells[LAME, place] / stiffening * theta * theta
    return ordered_sum(np.stack([of_links, of_volumes], axis=1))


@jit
def write_stresses(body, scratch, out):
    """Write the stresses xx, yy and xy of all automata, tension positive, shape (3, m) [Pa]: sigma = (1 / 2 V) sum r n F."""
    links, theta, begin = scratch.links, scratch.cells[DILATION], body.layout.begin
    twice, lame, traction = 2.0 * body.cells[SHEAR, begin], body.cells[LAME, begin], np.zeros(links.shape[1:])
    for component in range(3):
        for q in range(body.layout.offset.size):
            theta_j = theta[body.layout.offset[q] :]
            for p in range(theta_j.size):
                normal = twice * links[EPS, q, p] + lame * (0.5 * (theta[p] + theta_j[p]))
                parts = virial_stress(normal, twice * links[GAMMA, q, p], links[EX, q, p], links[EY, q, p])
                traction[q, p] = parts[component]
        sum_by_shares(body, traction, links, out[component])


class LinkedSpecimen:
    """A specimen whose links are elastic and never break, so that they have no histories.

    Attributes:
        has_histories: whether links have histories.
        fields: declarations of additional state variables.
        growing: declarations of additional lists of variable length in the state.
        event_kinds: the kinds of events, by name.
        event_details: units of the values of events, and what their indices count.
    """

    has_histories = False
    fields: Layout = {}
    growing: Layout = {}
    event_kinds: Mapping[str, str] = {}
    event_details: Mapping[str, EventDetail] = {}

    def __init__(self, packing: Packing, body: Body, conditions: Conditions, step_size: float, speed_limit: float) -> None:
        """Build from the packing, its `lattice.Body`, its `Conditions`, the internal step [s] and the speed limit [m/s]."""
        self.packing, self.body, self.conditions = packing, body, conditions
        self.scratch: Scratch = make_scratch(body, histories=self.has_histories)
        self.motion: Motion = make_motion(body.layout.size)
        self.step_size, self.speed_limit = step_size, speed_limit
        self.place = body.layout.place
        self.count = len(self.place)
        self._pairs = packing.pairs()
        self._at = self._pairs[:, 2], self.place[self._pairs[:, 0]]

    def attach_state(self, block: Block) -> None:
        """Attach the arrays of the state."""
        self._block = block
        self.inputs = Inputs(self.conditions.load, self.conditions.grip, block["tallies"])

    def reset_histories(self) -> None:
        """Write the initial histories."""

    def load_motion(self) -> None:
        """Copy the motion from the state to the fields."""
        block = self._block
        load_motion(self.body.layout, block["displacement"], block["velocity"], block["rotation"], block["spin"], self.motion)

    def store_motion(self) -> None:
        """Copy the motion from the fields to the state."""
        block = self._block
        store_motion(self.body.layout, block["displacement"], block["velocity"], block["rotation"], block["spin"], self.motion)

    def advance(self, tick: int, ticks: int) -> int:
        """Advance the motion by `ticks` steps from `tick` on, with the current loads and grips; return a status."""
        return advance(self.body, self.motion, self.scratch, self.inputs, self.step_size, ticks, self.speed_limit)

    def update_forces(self) -> None:
        """Write strains and forces of links and contacts for the present motion, so that outputs can be read."""
        update_forces(self.body, self.motion, self.scratch)

    def _measure_fields(self) -> None:
        self.load_motion()
        self.update_forces()

    def dilation(self) -> FloatArray:
        """Return the volume strain of each automaton, shape (n,)."""
        self._measure_fields()
        return self.scratch.cells[DILATION, self.place]

    def forces(self) -> FloatArray:
        """Return the sum of the forces of links and contacts on each automaton, shape (n, 2) [N]."""
        self._measure_fields()
        return np.ascontiguousarray(self.scratch.cells[FORCE_X : FORCE_Y + 1, self.place].T)

    def torques(self) -> FloatArray:
        """Return the sum of the torques of links and contacts on each automaton, shape (n,) [N m]."""
        self._measure_fields()
        return self.scratch.cells[TORQUE, self.place]

    def stress(self) -> FloatArray:
        """Return the stress of each automaton: xx, yy and xy, shape (n, 3) [Pa]."""
        self._measure_fields()
        found = np.zeros((3, self.body.layout.size))
        write_stresses(self.body, self.scratch, found)
        return np.ascontiguousarray(found[:, self.place].T)

    @np.errstate(all="ignore")
    def link_forces(self) -> FloatArray:
        """Return the force of each link along the line of centres, compression positive, shape (links,) [N]."""
        self._measure_fields()
        eps, gamma, ex, ey, force_x, force_y = self.scratch.links[EPS : SECOND_TERM + 1, *self._at]
        x, y = (1.0 + eps) * ex - gamma * ey, (1.0 + eps) * ey + gamma * ex
        return 0.0 - (force_x * x + force_y * y) / np.sqrt(x * x + y * y)

    def momenta_and_energies(self) -> FloatArray:
        """Return momentum, angular momentum about the origin, translational and rotational kinetic energy, shape (5,)."""
        self.load_motion()
        x, y, _, vx, vy, spin = self.motion[:, self.place]
        mass, inertia = self.body.cells[MASS : INERTIA + 1, self.place]
        x, y = self.body.cells[X, self.place] + x, self.body.cells[Y, self.place] + y
        turning = mass * (x * vy - y * vx) + inertia * spin
        energies = 0.5 * mass * (vx * vx + vy * vy), 0.5 * inertia * spin * spin
        return np.stack([mass * vx, mass * vy, turning, *energies]).cumsum(axis=1)[:, -1]

    def link_weights(self) -> FloatArray:
        """Return the weight of each link: 1 for an intact link, 0 for a released one."""
        return np.ones(len(self._pairs))

    def broken_link_count(self) -> float:
        """Return the number of broken links."""
        return 0.0

    def pressed_contact_count(self) -> float:
        """Return the number of contacts under pressure."""
        return 0.0

    def damage(self) -> FloatArray:
        """Return for each automaton the fraction of the area of its faces whose links are broken, shape (n,)."""
        return np.zeros(self.count)

    def stored_energies(self, slip_time: float) -> dict[str, float]:
        """Return the stored energies except kinetic ones [J]; `slip_time` is the time since the last force evaluation [s]."""
        self.load_motion()
        return self.field_energies(slip_time)

    def mean_energy(self, time: float) -> float:
        """Return the mean of the stored energies [J] a time [s] before and after the present, moved at present velocities.

        The last force evaluation was at that time before the present.
        """
        total = 0.0
        for way, since in ((-time, 0.0), (time, 2.0 * time)):
            self.load_motion()
            self.motion[:VX] += way * self.motion[VX:]
            total += ordered_sum(*self.field_energies(since).values())
        return 0.5 * total

    def field_energies(self, slip_time: float) -> dict[str, float]:
        """Return the energies stored at the present motion [J]; contacts have slid for `slip_time` since `slid` was set."""
        update_forces(self.body, self.motion, self.scratch)
        return {"elastic_energy": elastic_energy(self.body, self.scratch)}

    def report(self) -> dict[str, float]:
        """Return figures for the report: the largest strain of the links."""
        self._measure_fields()
        return {"largest strain of a link now": self._largest_strain()}

    def _largest_strain(self) -> float:
        return float(np.abs(self.scratch.links[EPS : GAMMA + 1, self.body.links[FACE] > 0.0]).max(initial=0.0))

    def dissipated_energies(self) -> dict[str, float]:
        """Return the energies dissipated since the reset, by name [J]."""
        return {}
