"""Two threads for a large solid: each sweeps through half of its points, columns and nodes; the bits are those of one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.second_thread import available, call_both
from . import kernels
from .kernel_arrays import IntArray, Scratch, Solid, State

# Below this number of integration points a sweep is too short for two threads to meet after it.
LEAST_POINTS = 20_000
# Status and point of a failure, with what decided and its limit.
Failure = tuple[int, int, float, float]


def divides(solid: Solid) -> bool:
    """Return whether two threads advance a body."""
    return len(solid.body.volume) >= LEAST_POINTS and available()


def advance(
    solid: Solid, state: State, scratch: Scratch, signals: FloatArray, pressures: FloatArray, tally: FloatArray,
    first_tick: int, failed: IntArray,
) -> int:  # fmt: skip
    """Advance as `kernels.advance` does, whose arguments it takes."""
    for row in range(len(signals)):
        failed[1] = first_tick + row + 1
        kernels.drift(solid, state, scratch, signals[row], pressures, tally)
        failures = update_stresses(solid, state, scratch, lambda _: False)
        if failures:
            note_failure(failures[0], scratch, failed)
            return failures[0][0]
        finish_tick(solid, state, scratch, signals[row], pressures, tally)
    return 0


def update_stresses(solid: Solid, state: State, scratch: Scratch, is_bearable: Callable[[int], bool]) -> list[Failure]:
    """Advance the stresses of all points, but for those at which that fails; return these, ascending.

    It ends early, in either half of the points, behind a failure that the body cannot bear.
    """
    count = len(solid.body.volume)
    middle = count // 2
    first, second = (
        (solid, state, scratch, begin, end, is_bearable) for begin, end in ((0, middle), (middle, count))
    )  # fmt: skip
    one, other = call_both(update_part, first, second)
    return [*one, *other]


def update_part(
    solid: Solid, state: State, scratch: Scratch, begin: int, end: int, is_bearable: Callable[[int], bool]
) -> list[Failure]:
    """Advance the stresses of some points as `update_stresses` does."""
    found: list[Failure] = []
    failed = np.zeros(2, dtype=np.int64)
    while begin < end:
        status = int(kernels.update_stresses(solid, state, scratch, begin, end, failed))
        if status == 0:
            break
        point = int(failed[0])
        found.append((status, point, float(scratch.pull[point, 0]), float(scratch.pull[point, 1])))
        if not is_bearable(point):
            break
        begin = point + 1
    return found


def note_failure(failure: Failure, scratch: Scratch, failed: IntArray) -> None:
    """Write a failure where `kernels.advance` leaves it."""
    _, point, value, limit = failure
    failed[0], scratch.pull[point, 0], scratch.pull[point, 1] = point, value, limit


def finish_tick(
    solid: Solid, state: State, scratch: Scratch, signals: FloatArray, pressures: FloatArray, tally: FloatArray
) -> None:
    """Write the forces from the stresses, and make the second half kick."""
    sweep(kernels.hold_columns, solid, state, scratch, len(solid.hourglass.partner))
    sweep(kernels.gather_forces, solid, state, scratch, len(solid.body.mass))
    kernels.kick(solid, state, scratch, signals, pressures, tally)


def sweep(kernel: Callable[..., Any], solid: Solid, state: State, scratch: Scratch, count: int) -> None:
    """Call a kernel for so many columns or nodes, in two threads for a large body."""
    if not divides(solid):
        kernel(solid, state, scratch, 0, count)
        return
    middle = count // 2
    call_both(kernel, (solid, state, scratch, 0, middle), (solid, state, scratch, middle, count))
