"""Ticks of the solid, whose points, columns and nodes are swept in contiguous parts, one thread each.

Points gather from their neighbours and nodes from the points that see them, so the bits do not depend on the parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.parts import call_in_parts, split, thread_count
from . import hourglass, kernels
from .kernel_arrays import IntArray, Scratch, Solid, State

# Below this number of integration points a sweep is too short for threads to meet after it.
LEAST_POINTS = 20_000


class Failure(NamedTuple):
    """The failure of a tick at a point: a status of `kernel_arrays`, the value that decided, and its limit."""

    status: int
    point: int
    value: float
    limit: float


class Inputs(NamedTuple):
    """The inputs of a tick.

    Attributes:
        signals: means over the tick: the factor of the pressure, then velocities of edges, shape (k,).
        pressures: what the factor is multiplied by at each station of the inner surface, shape (stations,) [Pa].
        tally: what inputs and conditions have done, updated, shape (TALLY,).
    """

    signals: FloatArray
    pressures: FloatArray
    tally: FloatArray


def advance(
    solid: Solid, state: State, scratch: Scratch, signals: FloatArray, pressures: FloatArray, tally: FloatArray,
    first_tick: int, failed: IntArray,
) -> int:  # fmt: skip
    """Advance by as many ticks as `signals` has rows; return 0 or a status of `kernel_arrays`.

    Args:
        solid: tables.
        state: updated.
        scratch: of the kernels.
        signals: as in `Inputs`, of each tick, shape (ticks, k).
        pressures: as in `Inputs`.
        tally: as in `Inputs`.
        first_tick: before the first of these ticks.
        failed: written: of a failure the point and the tick, shape (2,).
    """
    if _part_count(solid) == 1:
        return int(kernels.advance(solid, state, scratch, signals, pressures, tally, first_tick, failed))
    for row in range(len(signals)):
        inputs = Inputs(signals[row], pressures, tally)
        failures = advance_tick(solid, state, scratch, inputs, first_tick + row, lambda _: False)
        if failures:
            return note_failure(failures[0], scratch, first_tick + row, failed)
    return 0


def advance_tick(
    solid: Solid, state: State, scratch: Scratch, inputs: Inputs, tick: int, is_bearable: Callable[[int], bool]
) -> list[Failure]:
    """Advance by a tick; return the points at which that failed, ascending, after which the tick is yet to be finished.

    A part of the points ends early, behind a failure that the body cannot bear.
    """
    count, parts = len(solid.body.volume), _part_count(solid)
    if parts == 1:
        failed = np.zeros(2, dtype=np.int64)
        status = int(kernels.advance(solid, state, scratch, inputs.signals[None], *inputs[1:], tick, failed))
        if status == 0:
            return []
        first = _failure_at(status, int(failed[0]), scratch)
        others = update_part(solid, state, scratch, first.point + 1, count, is_bearable) if is_bearable(first.point) else []
        return [first, *others]
    kernels.drift(solid, state, scratch, *inputs)
    found = call_in_parts(update_part, [(solid, state, scratch, *part, is_bearable) for part in split(count, parts)])
    failures = [failure for part in found for failure in part]
    if not failures:
        finish_tick(solid, state, scratch, inputs)
    return failures


def finish_tick(solid: Solid, state: State, scratch: Scratch, inputs: Inputs) -> None:
    """Write the forces from the stresses, and make the second half kick."""
    write_forces(solid, state, scratch)
    kernels.kick(solid, state, scratch, *inputs)


def write_forces(solid: Solid, state: State, scratch: Scratch) -> None:
    """Write the forces on the nodes from the stresses."""
    columns, nodes = len(solid.hourglass.partner), len(solid.body.mass)
    if columns:
        _sweep(hourglass.hold_columns, solid, state, scratch, columns)
    _sweep(kernels.gather_forces, solid, state, scratch, nodes)


def update_forces(solid: Solid, state: State, scratch: Scratch, failed: IntArray) -> int:
    """Advance stresses to the displacements of now, and write the forces; return 0 or a status of `kernel_arrays`."""
    status = int(kernels.update_stresses(solid, state, scratch, 0, len(solid.body.volume), failed))
    if status == 0:
        write_forces(solid, state, scratch)
    return status


def update_part(
    solid: Solid, state: State, scratch: Scratch, begin: int, end: int, is_bearable: Callable[[int], bool]
) -> list[Failure]:
    """Advance the stresses of the points begin..end-1; return the failures, the last of which the body may not bear."""
    found: list[Failure] = []
    failed = np.zeros(2, dtype=np.int64)
    while begin < end:
        status = int(kernels.update_stresses(solid, state, scratch, begin, end, failed))
        if status == 0:
            break
        found.append(_failure_at(status, int(failed[0]), scratch))
        if not is_bearable(found[-1].point):
            break
        begin = found[-1].point + 1
    return found


def note_failure(failure: Failure, scratch: Scratch, tick: int, failed: IntArray) -> int:
    """Write a failure in the tick after `tick` to `failed` and to the row of its point in the scratch; return its status."""
    failed[:] = failure.point, tick + 1
    scratch.pull[failure.point, :2] = failure.value, failure.limit
    return failure.status


def _failure_at(status: int, point: int, scratch: Scratch) -> Failure:
    return Failure(status, point, float(scratch.pull[point, 0]), float(scratch.pull[point, 1]))


def _part_count(solid: Solid) -> int:
    return thread_count() if len(solid.body.volume) >= LEAST_POINTS else 1


def _sweep(kernel: Callable[..., Any], solid: Solid, state: State, scratch: Scratch, count: int) -> None:
    """Call a kernel for so many columns or nodes."""
    call_in_parts(kernel, [(solid, state, scratch, *part) for part in split(count, _part_count(solid))])
