"""Ticks (internal steps) of the grid with the steps of the automata in them, in stages (see `schemes`).

`advance` can stop so that the caller enlarges the lists of contacts and of broken links, and continue from there. One of
`linked_body` and `cracking` is None, so that numba does not compile the branch that a run does not need.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.contacts import dashpot_power
from ..automata.kernels import yield_and_check_links
from ..automata.link_release import DAMPING, TRAVEL
from ..automata.loads import count_fast_automata, largest_speed
from ..grid.mesh import IntArray
from ..support.jit import jit
from .parts import update_automata_forces
from .schemes import begin_step, begin_tick, end_step, end_tick
from .side_contacts import add_side_forces, largest_side_speed

# Results of `advance`: all ticks are done, a tick has failed, or the reason for an interruption.
DONE, INVERTED, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3, 4
# Entries of `CallProgress.progress`: number of the tick in the call, of the step of the automata in the tick, and of its stage.
ROW, MICRO, STAGE, PROGRESS = 0, 1, 2, 3
# Stages: before a tick, before a step of the automata, after its links have been checked.
BEGIN_TICK, BEGIN_STEP, END_STEP = 0, 1, 2


class CallProgress(NamedTuple):
    """The progress of a call of `advance`.

    Attributes:
        progress: the point at which `advance` has stopped and continues, shape (PROGRESS,); zeros at the beginning of a call.
        failure: the number of an inverted cell, if any, and the tick at which a part failed, shape (2,).
    """

    progress: IntArray
    failure: IntArray


@jit
def advance(grid, automata, linked_body, cracking, seam, factors, steps, tick, call):
    """Advance by whole ticks, or until links break or contacts have to be searched again.

    Args:
        grid: a `parts.GridPart`.
        automata: a `parts.AutomataPart`.
        linked_body: `lattice.Body` of automata whose links stay intact and elastic; None for others.
        cracking: a `parts.CrackingPart`; None for automata whose links stay intact and elastic.
        seam: a `parts.Seam`.
        factors: means of the grid's signals (see `grid.kernel_arrays`) over each tick, shape (ticks, signals).
        steps: a scheme, see `schemes`.
        tick: number of the tick at the beginning of the first row.
        call: a `CallProgress`, updated.

    Returns:
        DONE, INVERTED or TOO_FAST; SEARCH before a step of the automata, BREAK in the middle of a step.
    """
    progress, time, rows = call.progress, steps.step / steps.micro, len(factors)
    while progress[ROW] < rows:
        row = progress[ROW]
        now, has_next_tick, failed, fast = tick + row + 1, row + 1 < rows, np.int64(-1), 0
        if progress[STAGE] == BEGIN_TICK:
            begin_tick(steps, grid, automata, seam, factors, row)
            progress[MICRO], progress[STAGE] = 0, BEGIN_STEP
        while progress[MICRO] < steps.micro:
            own_tick = (now - 1) * steps.micro + progress[MICRO]
            if progress[STAGE] == BEGIN_STEP:
                if cracking is not None:
                    if cracking.specimen.losses[TRAVEL] > cracking.travel_limit:
                        return SEARCH
                begin_step(steps, grid, automata, seam, factors, row)
                progress[STAGE] = END_STEP
                if cracking is not None:
                    cracking.specimen.losses[TRAVEL] += time * largest_speed(automata.motion)
                    cracking.specimen.losses[TRAVEL] += time * largest_side_speed(cracking.sides, grid.state.velocity)
                    if yield_and_check_links(cracking.specimen, cracking.contacts, time, own_tick):
                        return BREAK
            update_automata_forces(automata, linked_body, cracking, seam, time, own_tick)
            if cracking is not None:
                nodes = grid.grid.reference, grid.state.displacement
                add_side_forces(cracking.sides, nodes, automata, seam.exchange.automata_force)
            failed = end_step(steps, grid, automata, seam, now, has_next_tick)
            fast += count_fast_automata(automata.motion, steps.speed_limit * steps.speed_limit)
            if cracking is not None:
                if cracking.specimen.medium.contact_constants.damping > 0.0:
                    # Between the two halves of the kick the velocities are the mean velocities of the step.
                    power = dashpot_power(automata.body.layout.place, cracking.contacts, automata.motion)
                    cracking.specimen.losses[DAMPING] += time * power
            progress[MICRO], progress[STAGE] = progress[MICRO] + 1, BEGIN_STEP
        bad = end_tick(steps, grid, automata, seam, factors, row, now, has_next_tick)
        failed = bad if failed < 0 else failed
        if failed >= 0 or fast:
            call.failure[0], call.failure[1] = failed, now
            return INVERTED if failed >= 0 else TOO_FAST
        progress[ROW], progress[STAGE] = row + 1, BEGIN_TICK
    return DONE
