"""Interleaved measurement: what is compared runs in turns, so that a machine that slows down slows down both.

Times are those that this thread had a core for: what else the machine does counts less then. Where several threads or
processes share the work, the wall's clock is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import perf_counter, thread_time

import numpy as np

Call = Callable[[], object]
Times = dict[str, np.ndarray]


def seconds(call: Call, *, wall: bool = False) -> float:
    """Return the time of one call on a core, or by the wall's clock [s]."""
    clock = perf_counter if wall else thread_time
    begin = clock()
    call()
    return clock() - begin


def interleaved(
    calls: Mapping[str, Call], rounds: int, before: Call = lambda: None, *, wall: bool = False, uncounted: int = 1
) -> Times:
    """Return the times of each call in each of so many rounds, shape (rounds,) [s], after some that are not counted.

    `before` is called before each call, untimed.
    """
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(uncounted + rounds):
        for name, call in calls.items():
            before()
            times[name].append(seconds(call, wall=wall))
    return {name: np.array(values[uncounted:]) for name, values in times.items()}


def ratio(above: np.ndarray, below: np.ndarray) -> float:
    """Median of the rounds' ratios: one disturbed round does not move it."""
    return float(np.median(above / below))


def microseconds(times: np.ndarray, calls: int) -> float:
    """Median time of one of `calls` calls [us]."""
    return float(np.median(times)) / calls * 1e6


def repeats_for(call: Call, wanted: float) -> int:
    """How often to repeat a call so that all together take about `wanted` seconds."""
    call()
    return max(1, round(wanted / max(min(seconds(call) for _ in range(3)), 1e-7)))
