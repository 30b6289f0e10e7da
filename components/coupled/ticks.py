"""Ticks of the grid and of the automata on one state, in stages.

`advance` can stop where the lists of contacts and of broken links need more room, and continue from there. See `schemes` for
the stages. Code that a run does not need is not compiled: of `linked` and `cracking` one is None.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.contacts import dashpot_power
from ..automata.loads import count_fast, largest_speed
from ..automata.release import DAMPING, TRAVEL
from ..automata.ticks import judge_links
from ..grid.mesh import IntArray
from ..support.jit import jit
from .parts import update_automata_forces
from .schemes import act, begin_tick, end_tick, move
from .side_contacts import add_side_forces, largest_speed_of_sides

# Results of `advance`: all ticks are done, one has failed, or the reason why it stopped.
DONE, INVERTED, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3, 4
# Entries of `Course.progress`: the tick in the call, the step of the automata in it, and the stage of that.
ROW, MICRO, STAGE, PROGRESS = 0, 1, 2, 3
# Stages: before a tick, before a step of the automata, after its links have been judged.
BEGIN, MOVE, ACT = 0, 1, 2


class Course(NamedTuple):
    """How far a call has come.

    Attributes:
        progress: where `advance` has stopped and continues, shape (PROGRESS,); zeros at the beginning of a call.
        failure: where a cell is inverted, its number; and the tick at which anything failed, shape (2,).
    """

    progress: IntArray
    failure: IntArray


@jit
def advance(grid, automata, linked, cracking, seam, factors, steps, tick, course):
    """Advance by whole ticks, or up to where links break or contacts have to be found again.

    Args:
        grid: a `parts.GridPart`.
        automata: a `parts.AutomataPart`.
        linked: the body of automata that stay linked and elastic; None for others.
        cracking: a `parts.Cracking`; None for automata that stay linked and elastic.
        seam: a `parts.Seam`.
        factors: of the signals of the grid in the middle of each tick, shape (ticks, signals), one row for each tick.
        steps: a scheme, see `schemes`.
        tick: at the beginning of the first row.
        course: a `Course`, updated.

    Returns:
        DONE, INVERTED or TOO_FAST; SEARCH before a step of the automata, BREAK in the middle of one.
    """
    progress, time, rows = course.progress, steps.step / steps.micro, len(factors)
    while progress[ROW] < rows:
        row = progress[ROW]
        now, again, failed, fast = tick + row + 1, row + 1 < rows, np.int64(-1), 0
        if progress[STAGE] == BEGIN:
            begin_tick(steps, grid, automata, seam, factors, row)
            progress[MICRO], progress[STAGE] = 0, MOVE
        while progress[MICRO] < steps.micro:
            own_tick = (now - 1) * steps.micro + progress[MICRO]
            if progress[STAGE] == MOVE:
                if cracking is not None:
                    if cracking.specimen.losses[TRAVEL] > cracking.most_travel:
                        return SEARCH
                move(steps, grid, automata, seam, factors, row)
                progress[STAGE] = ACT
                if cracking is not None:
                    cracking.specimen.losses[TRAVEL] += time * largest_speed(automata.motion)
                    cracking.specimen.losses[TRAVEL] += time * largest_speed_of_sides(cracking.sides, grid.state.velocity)
                    if judge_links(cracking.specimen, cracking.contacts, time, own_tick):
                        return BREAK
            update_automata_forces(automata, linked, cracking, seam, time, own_tick)
            if cracking is not None:
                nodes = grid.grid.reference, grid.state.displacement
                add_side_forces(cracking.sides, nodes, automata, seam.exchange.automata_force)
            failed = act(steps, grid, automata, seam, now, again)
            fast += count_fast(automata.motion, steps.speed_limit * steps.speed_limit)
            if cracking is not None:
                if cracking.specimen.medium.ground.damping > 0.0:
                    # Between the two halves of the kick, so that these are the mean velocities.
                    power = dashpot_power(automata.body.layout.place, cracking.contacts, automata.motion)
                    cracking.specimen.losses[DAMPING] += time * power
            progress[MICRO], progress[STAGE] = progress[MICRO] + 1, MOVE
        bad = end_tick(steps, grid, automata, seam, factors, row, now, again)
        failed = bad if failed < 0 else failed
        if failed >= 0 or fast:
            course.failure[0], course.failure[1] = failed, now
            return INVERTED if failed >= 0 else TOO_FAST
        progress[ROW], progress[STAGE] = row + 1, BEGIN
    return DONE
