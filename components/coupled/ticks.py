"""One tick of the grid and of the automata on one state.

Both move by kick, drift, kick. In lockstep (one micro-step) an interface node feels the sum of both forces, m a = F with the
masses of both: leapfrog for the whole, which conserves momentum and its discrete energy to rounding. With several micro-steps
the impulse scheme (reversible multiple time steps: M. Tuckerman, B. Berne, G. Martyna, J. Chem. Phys. 97 (1992) 1990): the
forces of the cells kick once before and once after the micro-steps of the automata, with which the interface nodes move; what
passes is impulses W^T F and velocities W v of micro-steps, never a force that is held.

See `lockstep`, `multiple_time_steps` and `literal_scheme`. A tick goes on in stages, so that `advance` can stop where the lists
of contacts and of broken links need more room, and go on from there. What a run does not need is not compiled: arguments that
are None take their branches with them.
"""

from __future__ import annotations

import numpy as np

from ..automata.contact import dashpot_power
from ..automata.link_release import DAMPING, TRAVEL
from ..automata.linked_sweep import DRIFT_HALF_KICK, DRIFT_TWO_HALF_KICKS, STILL
from ..support.jit import jit
from .kicks_and_drifts import finish_cells, must_break, note_travel, update_automata_forces
from .literal_scheme import act_literally, begin_literally, finish_literally, move_literally
from .lockstep import finish_together, move_together
from .multiple_time_steps import act_with_impulses, begin_impulses, finish_impulses, move_with_impulses, use_mean_velocities
from .side_contacts import add_side_forces, note_travel_of_sides

# What `advance` returns: all ticks are done, one has failed, or what has to be done before it goes on.
DONE, INVERTED, TOO_FAST, SEARCH, BREAK = 0, 1, 2, 3, 4
# Entries of `progress`: the tick in the call, the step of the automata in it, and the stage of that.
ROW, MICRO, STAGE, PROGRESS = 0, 1, 2, 3
# Stages: before a tick, before a step of the automata, after its links have been judged.
BEGIN, MOVE, ACT = 0, 1, 2


@jit
def advance(grid, automata, cracking, seam, factors, steps, impulses, literal, tick, progress, failure_out):
    """Advance by whole ticks, or up to where links break or contacts have to be found anew.

    Args:
        grid: a `GridPart`.
        automata: an `AutomataPart`.
        cracking: a `Cracking`; None for automata that stay linked and elastic.
        seam: a `Seam`.
        factors: of the signals of the grid in the middle of each tick, shape (ticks, signals); how many rows, so many ticks.
        steps: a `Steps`.
        impulses: 1 for several steps of the automata in a tick, else None.
        literal: 1 for the sub-steps of the paper, else None; with neither, both parts advance in lockstep.
        tick: at the beginning of the first row.
        progress: where to go on, and where this has stopped, shape (PROGRESS,); zeros at the beginning of a call.
        failure_out: where a cell is inverted, its number; and the tick at which anything failed, shape (2,).

    Returns:
        DONE, INVERTED or TOO_FAST; SEARCH before a step of the automata, BREAK in the middle of one.
    """
    # The kinds of steps are told apart here alone: each further function that gets all these tuples compiles for half a second.
    time, rows, fastest, status, first = steps.step / steps.micro, len(factors), 0.0, 0, True
    while progress[ROW] < rows:
        row = progress[ROW]
        now, again, failed = tick + row + 1, row + 1 < rows, np.int64(-1)
        if progress[STAGE] == BEGIN:
            if impulses is not None:
                begin_impulses(grid, automata, seam, factors, row, steps)
            elif literal is not None:
                begin_literally(seam)
            progress[MICRO], progress[STAGE] = 0, MOVE
        while progress[MICRO] < steps.micro:
            own_tick = (now - 1) * steps.micro + progress[MICRO]
            if progress[STAGE] == MOVE:
                if cracking is not None:
                    if cracking.losses[TRAVEL] > cracking.most_travel:
                        return SEARCH
                if impulses is not None:
                    move_with_impulses(grid, automata, seam, steps, time, first)
                elif literal is not None:
                    move_literally(grid, automata, seam, time)
                else:
                    move_together(grid, automata, seam, factors, row, steps)
                progress[STAGE] = ACT
                if cracking is not None:
                    note_travel(automata, cracking, time)
                    note_travel_of_sides(cracking.sides, grid, cracking.losses, time)
                    if must_break(automata, cracking, time, own_tick):
                        return BREAK
            moves, first = STILL, False
            if steps.swept is not None:
                moves = DRIFT_TWO_HALF_KICKS if again or progress[MICRO] + 1 < steps.micro else DRIFT_HALF_KICK
            status += update_automata_forces(automata, cracking, seam, steps, time, own_tick, moves)
            if cracking is not None:
                add_side_forces(cracking.sides, grid, automata, seam.exchange)
            if impulses is not None:
                fastest = act_with_impulses(grid, automata, seam, steps, time)
            elif literal is not None:
                fastest = act_literally(grid, automata, seam, time, steps.micro, steps.speed_limit * steps.speed_limit)
            else:
                failed = finish_cells(grid, seam, steps.step, now, again)
                fastest = finish_together(grid, automata, seam, steps)
            if cracking is not None:
                if cracking.medium.ground.damping > 0.0:
                    # Between the two halves of the kick, so that these are the mean velocities.
                    power = dashpot_power(cracking.contacts, cracking.contact_count, automata.motion.velocity)
                    cracking.losses[DAMPING] += time * power
            progress[MICRO], progress[STAGE] = progress[MICRO] + 1, MOVE
        if impulses is not None:
            use_mean_velocities(grid, seam, steps.step)
            failed = finish_cells(grid, seam, steps.step, now, again)
            finish_impulses(grid, automata, seam, steps.step)
        elif literal is not None:
            failed = finish_literally(grid, automata, seam, factors, row, steps, now, again)
        if failed >= 0 or status or not fastest <= steps.speed_limit * steps.speed_limit:
            failure_out[0], failure_out[1] = failed, now
            return INVERTED if failed >= 0 else TOO_FAST
        progress[ROW], progress[STAGE] = row + 1, BEGIN
    return DONE
