"""Division of a body into contiguous parts, each computed by its own thread.

A node or an automaton sums its forces in a fixed order, so the results are bitwise independent of the number of parts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Any


def thread_count() -> int:
    """Return ``GRANULAR_ENV_THREADS``, or else the number of cores that this process may use."""
    given = os.environ.get("GRANULAR_ENV_THREADS", "")
    if given.isdigit() and int(given) > 0:
        return int(given)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def split_range(size: int, parts: int) -> list[tuple[int, int]]:
    """Return the half-open ranges of contiguous parts of nearly equal size."""
    ends = [size * part // parts for part in range(parts + 1)]
    return list(zip(ends[:-1], ends[1:], strict=True))


def call_in_threads(kernel: Callable[..., Any], arguments: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Call a kernel that releases the GIL with each tuple of arguments, the first in this thread; return the results in order.

    All calls have finished when this returns or raises, so that no thread writes to a state that is being restored.
    """
    first, *others = arguments
    if not others:
        return [kernel(*first)]
    futures = [_thread_pool(os.getpid(), len(others)).submit(kernel, *each) for each in others]
    try:
        result = kernel(*first)
    finally:
        wait(futures)
    return [result, *(future.result() for future in futures)]


@cache
def _thread_pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Return the thread pool of this process; a forked process does not inherit the threads of its parent."""
    return ThreadPoolExecutor(threads, "component")
