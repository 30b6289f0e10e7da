"""Internal steps of a specimen whose links may yield and break, and whose pieces touch.

The forces of a position are computed in two parts, `judge_bonds` and `add_forces`: between them lies what needs more room in
lists, links that break (`rupture.break_bonds`) or are made anew (`link_formation.link_contacts`). A parent that moves the
automata itself calls these; `advance` puts them between the halves of a drift, as `linked_steps.advance` does with the forces
of linked automata.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .contact import Ground, add_contacts, dashpot_power
from .inelastic_links import Law, bond_forces, bond_stresses, update_bonds
from .kernel_arrays import Body, Motion, Scratch
from .link_histories import Bonds
from .link_release import DAMPING, FRICTION, INELASTIC, TRAVEL, lower_weights, settle_weights
from .motion import Grip, Load, add_loads, drift, held_speed, hold, keep_velocities, kick, settle_loads
from .pair import orient
from .strain_division import bond_dilations

# What `advance` returns: all steps are done, or what has to be done now.
DONE, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3


class Judgement(NamedTuple):
    """The numbers that decide on links in one internal step.

    Attributes:
        stress: of the automata, shape (n, 3) [Pa].
        mark: see `inelastic_links.update_bonds`, shape (n, slots / 2).
    """

    stress: FloatArray
    mark: FloatArray


class Medium(NamedTuple):
    """A specimen and what its links and contacts are: the first arguments of the kernels here."""

    body: Body
    ground: Ground
    bonds: Bonds
    law: Law


class Specimen(NamedTuple):
    """A medium, where it is, and what its steps write.

    Attributes:
        medium: a `Medium`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`.
        scratch: a `Scratch`.
        judgement: a `Judgement`.
        losses: see `link_release.FRACTURE`.
    """

    medium: Medium
    reference: FloatArray
    motion: Motion
    scratch: Scratch
    judgement: Judgement
    losses: FloatArray


class Inputs(NamedTuple):
    """Loads and grips, with memory for what was before a kick, and what they gave.

    Attributes:
        load: a `Load`.
        load_before: scratch, shape (loads, 3).
        grip: a `Grip`.
        grip_before: scratch, shape (grips, 3).
        tallies: of the loads and of the grip, see `motion`, shape (2, 4).
    """

    load: Load
    load_before: FloatArray
    grip: Grip
    grip_before: FloatArray
    tallies: FloatArray


class Pace(NamedTuple):
    """The length of a step, and how fast and how far automata may move.

    Attributes:
        time: length of a step [s].
        speed_limit: no automaton may be faster [m/s].
        most_travel: how far the fastest automaton may move before contacts are found anew [m].
    """

    time: float
    speed_limit: float
    most_travel: float


@internal
def judge_bonds(medium, motion, scratch, judgement, contacts, count, losses, time, tick):
    """Let links weaken and yield in the positions as they are, and judge which have to break or may be made anew.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        scratch: a `Scratch`, overwritten.
        judgement: a `Judgement`, overwritten.
        contacts: `Contacts`.
        count: how many contacts there are.
        losses: see `link_release.FRACTURE`, updated in place.
        time: since the forces were computed last [s].
        tick: number of the step.

    Returns:
        Whether links have to break, are being made anew, or it is time to look which may be.
    """
    body, bonds, law = medium.body, medium.bonds, medium.law
    automata = body.kind.size
    orient(motion.rotation, scratch.half, 0, automata)
    u = motion.displacement
    rising = lower_weights(body, bonds, law, contacts, count, tick)
    bond_dilations(body, bonds, u, scratch.half, scratch.dilation, 0, automata)
    if law.elastic and not law.criterion:
        return rising
    bond_stresses(body, bonds, u, scratch.half, scratch.dilation, judgement.stress, 0, automata)
    half, dilation = scratch.half, scratch.dilation
    marked, lost = update_bonds(body, bonds, law, motion, half, dilation, judgement.stress, time, judgement.mark)
    losses[INELASTIC] += lost
    return marked > 0 or rising or (law.linking_ticks > 0 and tick % law.linking_ticks == 0)


@internal
def add_forces(medium, motion, scratch, contacts, count, losses, time, tick):
    """Write the forces and torques of links and contacts, and end what `judge_bonds` began.

    Args:
        medium: a `Medium`.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        scratch: a `Scratch`, overwritten.
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        losses: see `link_release.FRACTURE`, updated in place.
        time: since the forces were computed last [s].
        tick: number of the step.
    """
    body, u, half = medium.body, motion.displacement, scratch.half
    bond_forces(body, medium.bonds, u, half, scratch.dilation, scratch.force, scratch.torque, 0, body.kind.size)
    rubbed, damped = add_contacts(
        body, medium.ground, medium.bonds, motion, contacts, count, medium.law.release, time, scratch.force, scratch.torque
    )
    losses[FRICTION] += rubbed
    losses[DAMPING] += damped
    settle_weights(body, medium.ground, medium.bonds, medium.law, motion, half, contacts, count, tick, losses)


@internal
def move(specimen, inputs, contacts, count, time):
    """Kick with the forces that there are and with the loads, and drift to the end of an internal step.

    Args:
        specimen: a `Specimen`; its motion, forces and losses are updated, of which TRAVEL by the way of the fastest automaton.
        inputs: `Inputs`; the tallies are updated.
        contacts: `Contacts`, with the forces of the dashpots.
        count: how many contacts there are.
        time: length of a step [s].

    Returns:
        The largest squared speed [m^2/s^2] before velocities are prescribed; NaN where one is not a number any more.
    """
    body, damping, motion, scratch = specimen.medium.body, specimen.medium.ground.damping, specimen.motion, specimen.scratch
    losses, tallies, automata = specimen.losses, inputs.tallies, specimen.medium.body.kind.size
    add_loads(
        inputs.load, specimen.reference, motion, scratch.force, scratch.torque, time, inputs.load_before, tallies[0]
    )  # fmt: skip
    keep_velocities(inputs.grip, motion, inputs.grip_before)
    if damping > 0.0:
        losses[DAMPING] += 0.5 * time * dashpot_power(contacts, count, motion.velocity)
    fastest = kick(body, motion, scratch.force, scratch.torque, time, 0, automata)
    hold(body, inputs.grip, specimen.reference, motion, scratch.force, scratch.torque, time, inputs.grip_before, tallies[1])
    settle_loads(inputs.load, motion, time, inputs.load_before, tallies[0])
    if damping > 0.0:
        losses[DAMPING] += 0.5 * time * dashpot_power(contacts, count, motion.velocity)
    drift(motion, 0.5 * time, 0, automata)
    losses[TRAVEL] += time * np.sqrt(fastest)
    return fastest


@jit
def advance(specimen, inputs, contacts, count, pace, tick, ticks, judged):
    """Advance by so many internal steps, or up to where links break, are made anew, or contacts have to be found anew.

    Args:
        specimen: a `Specimen`, updated in place.
        inputs: `Inputs`; the tallies are updated.
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        pace: a `Pace`.
        tick: number of the first step.
        ticks: how many.
        judged: whether the first step goes on after its links have been judged, and broken.

    Returns:
        DONE or TOO_FAST; SEARCH before a step; BREAK in the middle of one. And how many steps were done.
    """
    medium, motion, scratch, losses = specimen.medium, specimen.motion, specimen.scratch, specimen.losses
    time, limit = pace.time, pace.speed_limit * pace.speed_limit
    for done in range(ticks):
        if not (judged and done == 0):
            if losses[TRAVEL] > pace.most_travel:
                return SEARCH, done
            drift(motion, 0.5 * time, 0, medium.body.kind.size)
            if judge_bonds(medium, motion, scratch, specimen.judgement, contacts, count, losses, time, tick + done):
                return BREAK, done
        add_forces(medium, motion, scratch, contacts, count, losses, time, tick + done)
        fastest = move(specimen, inputs, contacts, count, time)
        if not held_speed(motion.velocity, fastest, limit) <= limit:
            return TOO_FAST, done
    return DONE, ticks
