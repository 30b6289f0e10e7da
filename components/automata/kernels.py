"""Internal steps of a specimen whose links may yield and break, and whose pieces touch.

The forces at new positions are computed in two parts, `yield_and_check_links` and `write_forces`. In between, lists may have to
grow for links that break or are formed again (`CrackingSpecimen.update_links`). A parent that moves the automata calls these
parts directly. `advance` calls them between the halves of a drift, as `linked_specimen.advance` does with the forces of linked
automata.
"""

from __future__ import annotations

from typing import NamedTuple

from ..support.float_arrays import FloatArray
from ..support.jit import jit, spliced
from .contacts import add_contact_forces, dashpot_power
from .lattice import Motion, Scratch, update_ghost_velocities
from .link_release import DAMPING, FRICTION, INELASTIC, TRAVEL, apply_end_weights, apply_mean_weights
from .links import (
    Medium,
    count_failing_links,
    write_medium_forces,
    write_medium_strains,
    write_medium_stresses,
    write_medium_tractions,
    yield_links,
)
from .loads import count_fast_automata, drift, kick_with_inputs, largest_speed

# Results of `advance`: all steps are done, or the reason for an interruption.
DONE, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3


class Specimen(NamedTuple):
    """A medium, its motion, and the results of its steps.

    Attributes:
        medium: a `links.Medium`.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`.
        losses: energies dissipated since the reset, and the travel since the search, see `link_release.FRACTURE`.
    """

    medium: Medium
    motion: Motion
    scratch: Scratch
    losses: FloatArray


class StepLimits(NamedTuple):
    """The length of a step, and limits of the motion of automata.

    Attributes:
        time: length of a step [s].
        speed_limit: largest speed of an automaton [m/s].
        travel_limit: distance that the fastest automaton may move before the next search for contacts [m].
    """

    time: float
    speed_limit: float
    travel_limit: float


@spliced
def yield_and_check_links(specimen, contacts, time, tick):
    """Let links weaken and yield at the present positions, and find those that must break or may be formed again.

    `specimen` has the velocities since the last force evaluation, `time` [s] ago; `tick` is the number of the step.

    Returns:
        Whether links must break, links are being formed again, or a search for links to form again is due.
    """
    medium, motion, scratch, law = specimen.medium, specimen.motion, specimen.scratch, specimen.medium.law
    rising = apply_mean_weights(medium.body.layout, medium.histories.weight, contacts, tick, law.release)
    write_medium_strains(medium, motion, scratch)
    write_medium_tractions(medium, scratch)
    write_medium_stresses(medium, scratch)
    lost = yield_links(law.response, medium, motion, scratch, time)
    if lost != 0.0:
        write_medium_tractions(medium, scratch)
    specimen.losses[INELASTIC] += lost
    return count_failing_links(medium, scratch) > 0 or rising or (law.linking_ticks > 0 and tick % law.linking_ticks == 0)


@spliced
def write_forces(specimen, contacts, time, tick):
    """Write the forces and torques of links and contacts after `yield_and_check_links` in the same step; same arguments."""
    medium, motion, scratch, losses = specimen.medium, specimen.motion, specimen.scratch, specimen.losses
    write_medium_forces(medium, scratch)
    rubbed, damped = add_contact_forces(medium, motion, contacts, time, scratch.cells)
    losses[FRICTION] += rubbed
    losses[DAMPING] += damped
    apply_end_weights(medium, motion, scratch.links, contacts, tick, losses)


@jit
def write_current_fields(medium, motion, scratch, contacts):
    """Write strains, stresses and forces at the present positions without changing histories; contacts do not slide."""
    write_medium_strains(medium, motion, scratch)
    write_medium_tractions(medium, scratch)
    write_medium_stresses(medium, scratch)
    write_medium_forces(medium, scratch)
    add_contact_forces(medium, motion, contacts, 0.0, scratch.cells)


@jit
def advance(specimen, inputs, contacts, step_limits, tick, ticks, is_checked):
    """Advance by internal steps; stop if links break or are formed again, or if a new search for contacts is due.

    Args:
        specimen: a `Specimen`, updated in place; the distance of the fastest automaton is added to `losses[TRAVEL]`.
        inputs: `loads.Inputs`; the tallies are updated.
        contacts: `contacts.Contacts`, updated in place.
        step_limits: a `StepLimits`.
        tick: number of the first step.
        ticks: number of steps.
        is_checked: whether the links of the first step have already been checked and broken.

    Returns:
        DONE, TOO_FAST, SEARCH (before a step) or BREAK (in the middle of a step); and the number of completed steps.
    """
    medium, motion, losses, place = specimen.medium, specimen.motion, specimen.losses, specimen.medium.body.layout.place
    damps, time = medium.contact_constants.damping > 0.0, step_limits.time
    for done in range(ticks):
        if not (is_checked and done == 0):
            if losses[TRAVEL] > step_limits.travel_limit:
                return SEARCH, done
            drift(motion, 0.5 * time)
            if yield_and_check_links(specimen, contacts, time, tick + done):
                return BREAK, done
        write_forces(specimen, contacts, time, tick + done)
        if damps:
            losses[DAMPING] += 0.5 * time * dashpot_power(place, contacts, motion)
        kick_with_inputs(medium.body, motion, specimen.scratch.cells, inputs, time)
        if damps:
            losses[DAMPING] += 0.5 * time * dashpot_power(place, contacts, motion)
        update_ghost_velocities(medium.body.layout.ghosts, motion)
        drift(motion, 0.5 * time)
        losses[TRAVEL] += time * largest_speed(motion)
        if count_fast_automata(motion, step_limits.speed_limit * step_limits.speed_limit):
            return TOO_FAST, done
    return DONE, ticks
