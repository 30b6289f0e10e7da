"""Memory throughput of the grid relative to a triad."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numba
import numpy as np

import granular_env as ge
from granular_env.components.grid import kernels
from granular_env.components.grid.component import LEAST_CELLS
from granular_env.components.grid.kernel_arrays import Yields

from .figures import Figure
from .timing import median_ratio, repeats_for, time_interleaved

MEDIUM = {"density": 1.0, "young": 2.5, "poisson": 0.25}
# Required fraction of the memory roof for a mesh larger than the cache, and required gain from a second thread.
WANTED, LEAST_GAIN = 0.4, 1.3
# Side of the smallest square that uses two threads, which must not be slower there than one thread.
SMALLEST = math.isqrt(LEAST_CELLS - 1) + 1
_SAMPLE_SECONDS = 0.2
# Arrays of `kernel_arrays.Grid` and `kernel_arrays.State` that a tick reads, and arrays that it reads and writes.
_READ = ("reference", "cells", "half_inverse", "material", "hourglass", "node_slots", "special")
_WRITTEN = ("displacement", "velocity", "stress", "hourglass_force", "energy")


@numba.njit
def triad(a, b, c, repeats):
    """Compute a = b + 3 c `repeats` times."""
    for _ in range(repeats):
        for i in range(a.size):
            a[i] = b[i] + 3.0 * c[i]


def noisy_grid(side: int) -> Any:
    """Return a square of side x side cells with all nodes moving."""
    grid = ge.make("grid", mesh={"name": "rectangle", "columns": side, "rows": side, "cell_size": 1.0}, material=MEDIUM)
    grid.reset(velocity=1e-3 * np.random.default_rng(1).standard_normal(((side + 1) ** 2, 2)))
    return grid


def tick_bytes(grid: Any) -> int:
    """Return the bytes read and written per tick, counting each array once and no scratch memory."""
    read = sum(getattr(grid._grid, name).nbytes for name in _READ)
    return read + 2 * sum(getattr(grid._state, name).nbytes for name in _WRITTEN)


def _arguments(grid: Any, ticks: int) -> tuple[Any, ...]:
    return (
        grid.tables(), np.ones((ticks, 1)), grid._block["tally"], grid.step_size, 0,
        Yields(np.zeros((1, 5)), np.zeros(1, dtype=np.int64)), grid.failed_at,
    )  # fmt: skip


def _advance_single_thread(grid: Any, ticks: int) -> None:
    """Advance in one thread."""
    kernels.advance(*_arguments(grid, ticks))


def measure(
    sides: tuple[int, ...] = (60, 600), triad_words: int = 8_000_000, rounds: int = 11, smallest: int = SMALLEST
) -> Iterator[Figure]:
    """Measure squares of 3600 and 360,000 cells (only the first fits a cache), and the smallest square for two threads."""
    arrays = [np.ones(triad_words) for _ in range(3)]
    for side in sides:
        grid = noisy_grid(side)
        ticks = repeats_for(lambda grid=grid: _advance_single_thread(grid, 1), _SAMPLE_SECONDS)
        times = time_interleaved(
            {"grid": lambda g=grid, t=ticks: g._advance_state(t), "triad": lambda: triad(*arrays, 1)}, rounds, wall=True
        )
        moved = ticks * tick_bytes(grid) / (24 * triad_words)
        nodes = len(grid.mesh.nodes)
        rate = ticks * nodes / float(np.median(times["grid"])) / 1e6
        yield Figure(
            f"grid / triad, bytes per second, {nodes} nodes", moved * median_ratio(times["triad"], times["grid"]),
            at_least=WANTED if side == max(sides) else None,
            note=f"{rate:.1f} M node updates/s, {tick_bytes(grid) / nodes:.0f} bytes each",
        )  # fmt: skip
    yield _two_threads(max(sides), rounds, LEAST_GAIN)
    yield _two_threads(smallest, rounds, 1.0)


def _two_threads(side: int, rounds: int, at_least: float) -> Figure:
    """Compare two threads with one thread for the two parts of a grid."""
    grid = noisy_grid(side)
    ticks = repeats_for(lambda: _advance_single_thread(grid, 1), _SAMPLE_SECONDS)
    arguments = _arguments(grid, ticks)
    advances = {"one": lambda: kernels.advance(*arguments), "two": lambda: kernels.advance_in_parts(*arguments, 2)}
    times = time_interleaved(advances, rounds, wall=True)
    gain = median_ratio(times["one"], times["two"])
    return Figure(f"one thread / two, {len(grid.mesh.nodes)} nodes", gain, at_least=at_least, note="two parts")
