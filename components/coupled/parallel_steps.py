"""Two threads for a large body whose automata are swept: each has half of the cells and automata; the bits are those of one."""

from __future__ import annotations

from typing import Any

from ..automata.linked_sweep import DRIFT_HALF_KICK, DRIFT_TWO_HALF_KICKS, copy_ghosts, sweep
from ..automata.sweep_order import Part
from ..support.jit import jit
from ..support.second_thread import available, call_both
from .exchange import gather_forces
from .kicks_and_drifts import AutomataPart, GridPart, Seam, Steps, advance_cells, join_cells
from .lockstep import finish_together, move_together
from .multiple_time_steps import act_with_impulses, begin_impulses, finish_impulses, move_with_impulses, use_mean_velocities
from .ticks import DONE, INVERTED, TOO_FAST

__all__ = ["advance", "are_worth_it", "available"]

# Below this a sweep is too short for two threads to meet in: cells and automata in lockstep, automata with several micro-steps.
_LEAST = 50_000


def are_worth_it(cells: int, automata: int, micro: int) -> bool:
    """Return whether a body is so large that two threads are faster than one."""
    return (automata if micro > 1 else cells + automata) >= _LEAST


def advance(
    grid: GridPart, automata: AutomataPart, parts: list[Part], seam: Seam, factors: Any, steps: Steps, tick: int,
    failure_out: Any,
) -> int:  # fmt: skip
    """Advance by whole ticks as `ticks.advance` does, whose arguments it takes; `parts` are two of the automata."""
    rows, time = len(factors), steps.step / steps.micro
    for row in range(rows):
        now, again = tick + row + 1, row + 1 < rows
        if steps.micro == 1:
            begin_halves(grid, automata, seam, factors, row, steps)
            results = _call_halves(advance_half, grid, automata, parts, steps, now, again)
            cells, statuses = zip(*results, strict=True)
            fastest = finish_halves(grid, automata, seam, steps, again)
        else:
            cells, statuses, fastest = _make_micro_steps(grid, automata, parts, seam, factors, row, steps, now, again, time)
        inverted = [int(cell) for cell in cells if cell >= 0]
        if inverted or any(statuses) or not fastest <= steps.speed_limit * steps.speed_limit:
            failure_out[0], failure_out[1] = inverted[0] if inverted else -1, now
            return INVERTED if inverted else TOO_FAST
    return DONE


def _make_micro_steps(
    grid: GridPart, automata: AutomataPart, parts: list[Part], seam: Seam, factors: Any, row: int, steps: Steps, now: int,
    again: bool, time: float,
) -> tuple[Any, list[int], float]:  # fmt: skip
    """Make a tick with several steps of the automata; return cells that are inverted or -1, statuses, and a squared speed."""
    found: list[int] = []
    fastest = 0.0
    for micro in range(steps.micro):
        begin_micro_step(grid, automata, seam, factors, row, micro, steps, time)
        _copy_ghosts(automata, parts)
        last = not again and micro + 1 == steps.micro
        moves = DRIFT_HALF_KICK if last else DRIFT_TWO_HALF_KICKS
        whole, limit = (automata.motion, automata.scratch, automata.marked, automata.kept), steps.speed_limit**2
        first, second = ((automata.body, part, *whole, time, limit, moves) for part in parts)
        found += call_both(sweep, first, second)
        fastest = finish_micro_step(grid, automata, seam, micro, steps, time)
    cells = (advance_cells_half(grid, steps.step, now, again),)
    finish_micro_steps(grid, automata, seam, steps, again)
    return cells, found, fastest


def _call_halves(
    function: Any, grid: GridPart, automata: AutomataPart, parts: list[Part], steps: Steps, now: int, again: bool
) -> Any:
    _copy_ghosts(automata, parts)
    first, second = ((grid, automata, part, place, steps, now, again) for place, part in enumerate(parts))
    return call_both(function, first, second)


def _copy_ghosts(automata: AutomataPart, parts: list[Part]) -> None:
    """Copy what each part needs of the other before both move."""
    motion = automata.motion
    for part in parts:
        copy_ghosts(part, motion.displacement.reshape(-1), motion.velocity.reshape(-1), motion.rotation, motion.spin)


# Entries from Python to what `ticks.advance` calls, and these alone: they are compiled where threads are used.


@jit
def begin_halves(grid, automata, seam, factors, row, steps):
    """Begin a tick in lockstep."""
    move_together(grid, automata, seam, factors, row, steps)


@jit
def advance_half(grid, automata, part, place, steps, tick, again):
    """Advance one of two parts of the cells, and sweep through one of the automata, in lockstep.

    Returns:
        A cell that is inverted, or -1; and 0, or another number where an automaton is too fast.
    """
    failed = advance_cells(grid, steps.step, tick, again) if place == 0 else -1
    moves = DRIFT_TWO_HALF_KICKS if again else DRIFT_HALF_KICK
    limit = steps.speed_limit * steps.speed_limit
    motion, scratch = automata.motion, automata.scratch
    return failed, sweep(automata.body, part, motion, scratch, automata.marked, automata.kept, steps.step, limit, moves)


@jit
def finish_halves(grid, automata, seam, steps, again):
    """Finish a tick in lockstep after both halves; return the largest squared speed of the marked automata."""
    join_cells(grid, seam)
    gather_forces(seam.interface, automata.scratch.force, seam.exchange.automata_force)
    return finish_together(grid, automata, seam, steps)


@jit
def begin_micro_step(grid, automata, seam, factors, row, micro, steps, time):
    """Begin a micro-step, and the tick with the first one."""
    if micro == 0:
        begin_impulses(grid, automata, seam, factors, row, steps)
    move_with_impulses(grid, automata, seam, steps, time, row == 0 and micro == 0)


@jit
def finish_micro_step(grid, automata, seam, micro, steps, time):
    """Finish a micro-step after both halves; return the largest squared speed of the marked automata."""
    gather_forces(seam.interface, automata.scratch.force, seam.exchange.automata_force)
    fastest = act_with_impulses(grid, automata, seam, steps, time)
    if micro + 1 == steps.micro:
        use_mean_velocities(grid, seam, steps.step)
    return fastest


@jit
def advance_cells_half(grid, step, tick, again):
    """Advance the cells; return a cell that is inverted, or -1."""
    return advance_cells(grid, step, tick, again)


@jit
def finish_micro_steps(grid, automata, seam, steps, again):
    """Finish a tick of several micro-steps, all cells being advanced."""
    join_cells(grid, seam)
    finish_impulses(grid, automata, seam, steps.step)
