"""A second thread for work that one call can do in two parts; kernels let other threads run while they do."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

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
        _helpers[process] = ThreadPoolExecutor(1, "component")
    return _helpers[process]


def call_both(function: Callable[..., Any], first: tuple[Any, ...], second: tuple[Any, ...]) -> tuple[Any, Any]:
    """Call a function with both tuples of arguments at a time, the second in a thread of its own; return both results."""
    other = _helper().submit(function, *second)
    try:
        result = function(*first)
    finally:
        # Also where Ctrl-C comes in between: nobody may write to a state that is being restored.
        theirs = other.result()
    return result, theirs
