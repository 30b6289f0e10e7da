"""Ticks of the solid; points, columns and nodes are processed in contiguous parts, one thread each.

Points sum over their neighbours and nodes over their points, so the results are bitwise independent of the parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray, ordered_sum
from ..support.threads import call_in_threads, split_range, thread_count
from . import kernels
from .hourglass import write_tie_forces
from .kernel_arrays import WALL_FORCE, WALL_IMPULSE, IntArray, Scratch, Solid, State, Tables

# With fewer integration points a loop over them is too short to gain from threads.
LEAST_POINTS = 20_000


class Failure(NamedTuple):
    """The failure of a tick at a point: a status of `kernel_arrays`, the value that is too large, and its limit."""

    status: int
    point: int
    value: float
    limit: float


def advance(tables: Tables, signals: FloatArray, pressures: FloatArray, first_tick: int, failure_out: IntArray) -> int:
    """Advance by one tick per row of `signals`; return 0 or a status of `kernel_arrays`.

    Args:
        tables: tables of the kernels; the state in them is updated.
        signals: means over each tick: the factor of the pressure, then velocities of edges, shape (ticks, k).
        pressures: pressure that the factor scales at each station of the inner surface, shape (stations,) [Pa].
        first_tick: number at the beginning of the first of these ticks.
        failure_out: written: point and tick of a failure, shape (2,).
    """
    for row in range(len(signals)):
        failures = advance_tick(tables, signals[row], pressures, lambda _: False)
        if failures:
            return record_failure(failures[0], tables.scratch, first_tick + row, failure_out)
    return 0


def advance_tick(
    tables: Tables, signals: FloatArray, pressures: FloatArray, is_bearable: Callable[[int], bool]
) -> list[Failure]:
    """Advance by a tick; return the points at which it failed, ascending. After failures, `finish_tick` must still be called.

    A thread stops at a failure that `is_bearable` does not accept, because it ends the run.
    """
    solid, state, scratch, tally = tables
    kernels.drift(solid.nodes, solid.surface, state, scratch, signals, pressures, solid.step, tally)
    tally[WALL_IMPULSE] += 0.5 * solid.step * tally[WALL_FORCE]
    parts = split_range(len(solid.points.volume), _part_count(solid))
    found = call_in_threads(update_point_range, [(solid, state, scratch, *part, is_bearable) for part in parts])
    failures = [failure for part in found for failure in part]
    if not failures:
        finish_tick(tables, signals, pressures)
    return failures


def finish_tick(tables: Tables, signals: FloatArray, pressures: FloatArray) -> None:
    """Write the forces from the stresses, and make the second half kick."""
    solid, state, scratch, tally = tables
    write_forces(solid, state, scratch)
    kernels.write_areas(solid.surface, state.displacement, scratch.area)
    kernels.kick(solid.nodes, solid.surface, state, scratch, signals, pressures, solid.step, tally)
    write_wall_force(solid, state, tally)
    tally[WALL_IMPULSE] += 0.5 * solid.step * tally[WALL_FORCE]


def write_forces(
    solid: Solid, state: State, scratch: Scratch, columns: IntArray | None = None, nodes: IntArray | None = None
) -> None:
    """Write the forces on nodes by stresses, hourglass control and a wall; `scratch` has the pull of the points.

    `columns` are those whose ties have changed, `nodes` those whose forces have; all by default.
    """
    tied, points = solid.hourglass, solid.points
    columns = np.arange(len(tied.partner)) if columns is None else columns
    nodes = np.arange(len(solid.nodes.mass)) if nodes is None else nodes
    if len(columns):
        common = (tied, points, solid.law, solid.plastic, state, scratch)
        call_in_threads(write_tie_forces, [(*common, part) for part in _thread_parts(solid, columns)])
    common = (points, solid.nodes, tied, scratch, state.force)
    call_in_threads(kernels.gather_forces, [(*common, part) for part in _thread_parts(solid, nodes)])
    if len(solid.bounce):
        state.force[nodes, 0] += (solid.wall[1] * solid.bounce * wall_depths(solid, state))[nodes]


def wall_depths(solid: Solid, state: State) -> FloatArray:
    """Return how far each node lies behind the wall, shape (n,) [m], or an array of shape (0,) without a wall."""
    if not len(solid.bounce):
        return solid.bounce
    depth = solid.wall[1] * (solid.wall[0] - (solid.reference[:, 0] + state.displacement[:, 0]))
    return np.where(depth > 0.0, depth, 0.0)


def write_wall_force(solid: Solid, state: State, tally: FloatArray) -> None:
    """Write the present force of the wall on the body [N]."""
    if len(solid.bounce):
        tally[WALL_FORCE] = ordered_sum(solid.wall[1] * solid.bounce * wall_depths(solid, state))


def update_forces(solid: Solid, state: State, scratch: Scratch, failure_out: IntArray) -> int:
    """Advance stresses elastically to the present displacements, and write the forces; return 0 or a status."""
    elastic = solid._replace(plastic=False)
    status = _update_stresses(elastic, state, scratch, 0, len(solid.points.volume), failure_out)
    if status == 0:
        write_forces(elastic, state, scratch)
    return status


def update_point_range(
    solid: Solid, state: State, scratch: Scratch, begin: int, end: int, is_bearable: Callable[[int], bool]
) -> list[Failure]:
    """Advance the stresses of the points begin..end-1; return the failures, the last of which may end the run."""
    found: list[Failure] = []
    failed = np.zeros(2, dtype=np.int64)
    while begin < end:
        status = _update_stresses(solid, state, scratch, begin, end, failed)
        if status == 0:
            break
        point = int(failed[0])
        found.append(Failure(status, point, *scratch.pull[point, :2].tolist()))
        if not is_bearable(point):
            break
        begin = point + 1
    return found


def _update_stresses(solid: Solid, state: State, scratch: Scratch, begin: int, end: int, failure_out: IntArray) -> int:
    return int(kernels.update_stresses(solid.points, solid.law, solid.plastic, state, scratch.pull, begin, end, failure_out))


def record_failure(failure: Failure, scratch: Scratch, tick: int, failure_out: IntArray) -> int:
    """Write point and tick (`tick` + 1) of a failure to `failure_out`, value and limit to the scratch; return its status."""
    failure_out[:] = failure.point, tick + 1
    scratch.pull[failure.point, :2] = failure.value, failure.limit
    return failure.status


def _thread_parts(solid: Solid, numbers: IntArray) -> list[IntArray]:
    return [numbers[begin:end] for begin, end in split_range(len(numbers), _part_count(solid))]


def _part_count(solid: Solid) -> int:
    return thread_count() if len(solid.points.volume) >= LEAST_POINTS else 1
