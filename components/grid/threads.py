"""Two threads for a large grid: each advances a part of the mesh, then one finishes the tick; the bits are those of one."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from . import kernels

# Below this a tick is too short for two threads to meet in: measured, see docs/benchmarks.md.
LEAST_CELLS = 100_000

_helpers: dict[int, ThreadPoolExecutor] = {}


def available() -> bool:
    """Return whether this process may use two cores."""
    try:
        return len(os.sched_getaffinity(0)) > 1
    except AttributeError:  # not on every system
        return (os.cpu_count() or 1) > 1


def _helper() -> ThreadPoolExecutor:
    """Return the second thread of this process; a fork has none of its parent's."""
    process = os.getpid()
    if process not in _helpers:
        _helpers.clear()
        _helpers[process] = ThreadPoolExecutor(1, "grid")
    return _helpers[process]


def advance(
    grid: Any, state: Any, conditions: Any, factors: Any, corner: Any, tally: Any, step: float, tick: int, events: Any,
    counts: Any, failure_out: Any,
) -> int:  # fmt: skip
    """Advance a grid of two parts as `kernels.advance` does, whose arguments it takes."""
    submit, ticks = _helper().submit, len(factors)
    kernels.begin_advance(grid, state, conditions, factors, step)
    for row in range(ticks):
        inputs = (step, tick + row + 1, row + 1 < ticks, events, counts)
        second = submit(kernels.advance_part, grid, state, corner, 1, *inputs)
        first = -1
        try:
            first = int(kernels.advance_part(grid, state, corner, 0, *inputs))
        finally:
            # Also where Ctrl-C comes in between: nobody may write to a state that is being restored.
            other = int(second.result())
        first = first if first >= 0 else other
        if first >= 0:
            failure_out[0], failure_out[1] = first, tick + row + 1
            return 1
        kernels.finish_tick(grid, state, conditions, factors, corner, tally, row, step)
    return 0
