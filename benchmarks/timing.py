"""Interleaved measurement: the compared calls alternate, so that a slower machine affects all of them.

Times are CPU times of the calling thread, which reduces the effect of other load. If several threads or processes share the
work, wall time is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import perf_counter, thread_time

import numpy as np

Call = Callable[[], object]
Times = dict[str, np.ndarray]


def call_seconds(call: Call, *, wall: bool = False) -> float:
    """Return the CPU time, or the wall time, of one call [s]."""
    clock = perf_counter if wall else thread_time
    begin = clock()
    call()
    return clock() - begin


def time_interleaved(
    calls: Mapping[str, Call], rounds: int, before: Call = lambda: None, *, wall: bool = False, uncounted: int = 1
) -> Times:
    """Return the times of each call over `rounds` rounds, shape (rounds,) [s], after `uncounted` warm-up rounds.

    `before` runs untimed before each call.
    """
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(uncounted + rounds):
        for name, call in calls.items():
            before()
            times[name].append(call_seconds(call, wall=wall))
    return {name: np.array(values[uncounted:]) for name, values in times.items()}


def median_ratio(above: np.ndarray, below: np.ndarray) -> float:
    """Return the median of the rounds' ratios, which is robust to a disturbed round."""
    return float(np.median(above / below))


def microseconds(times: np.ndarray, calls: int) -> float:
    """Return the median time per call of `calls` calls [us]."""
    return float(np.median(times)) / calls * 1e6


def repeats_for(call: Call, wanted: float) -> int:
    """Return the number of repetitions of a call that take about `wanted` seconds in total."""
    call()
    return max(1, round(wanted / max(min(call_seconds(call) for _ in range(3)), 1e-7)))
