"""Ticks of a large grid on two threads: each advances a part of the mesh, then one finishes them; the bits are those of one."""

from __future__ import annotations

from typing import Any

from ..support.second_thread import available, call_both
from . import kernels

__all__ = ["LEAST_CELLS", "advance", "available"]

# Below this a tick is too short for two threads to meet in: measured, see docs/benchmarks.md.
LEAST_CELLS = 100_000


def advance(
    grid: Any, state: Any, conditions: Any, factors: Any, corner: Any, tally: Any, step: float, tick: int, events: Any,
    counts: Any, failure_out: Any,
) -> int:  # fmt: skip
    """Advance a grid of two parts as `kernels.advance` does, whose arguments it takes."""
    ticks = len(factors)
    kernels.begin_advance(grid, state, conditions, factors, step)
    for row in range(ticks):
        inputs = (step, tick + row + 1, row + 1 < ticks, events, counts)
        first, other = map(
            int, call_both(kernels.advance_part, (grid, state, corner, 0, *inputs), (grid, state, corner, 1, *inputs))
        )
        first = first if first >= 0 else other
        if first >= 0:
            failure_out[0], failure_out[1] = first, tick + row + 1
            return 1
        kernels.finish_tick(grid, state, conditions, factors, corner, tally, row, step)
    return 0
