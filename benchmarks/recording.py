"""What a recorder costs: a step from Python at 100 grains, and its share of a long run at 100,000."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

import granular_env as ge

from . import chains
from .figures import Figure
from .timing import interleaved, ratio


def measure(steps: int = 100_000, rounds: int = 5, long_grains: int = 100_000, long_steps: int = 4000, long_rounds: int = 3) -> Iterator[Figure]:
    """Both costs; 200 frames in 20,000 steps are the measure of the second, fewer steps have frames in proportion."""
    with TemporaryDirectory() as folder:
        yield _of_a_step(Path(folder) / "short.mcap", steps, rounds)
        yield _share(Path(folder) / "long.mcap", long_grains, long_steps, long_rounds)


def _of_a_step(path: Path, steps: int, rounds: int) -> Figure:
    """Stepping one internal step at a time with a new input each, from opening the log to its closing."""
    chain = chains.pressed(100, left="free")
    forces = np.random.default_rng(3).uniform(-1.0, 1.0, steps).tolist()
    start, inside = chain.save(), []

    def plain() -> None:
        chain.restore(start)
        for force in forces:
            chain.step(left_force=force)

    def recorded() -> None:
        chain.restore(start)
        with ge.record(chain, path, overwrite=True):
            begin = perf_counter()
            for force in forces:
                chain.step(left_force=force)
            inside.append(perf_counter() - begin)

    times = interleaved({"plain": plain, "recorded": recorded}, rounds)
    cost = float(np.median(times["recorded"] - times["plain"])) / steps * 1e6
    opening = float(np.median(times["recorded"] - np.array(inside[1:]))) * 1e3
    bare = float(np.median(times["plain"])) / steps * 1e6
    note = f"{steps} steps of {bare:.2f} us each unrecorded; opening and closing, {opening:.0f} ms in all, are part of it"
    return Figure("cost of a recorded step, 100 grains, a new input each", cost, "us", at_most=5.0, note=note)


def _share(path: Path, grains: int, steps: int, rounds: int) -> Figure:
    chain = chains.pressed(grains)
    frames = steps // 100
    start, duration = chain.save(), steps * chain.step_size

    def plain() -> None:
        chain.restore(start)
        chain.step(duration)

    def recorded() -> None:
        chain.restore(start)
        with ge.record(chain, path, every=100 * chain.step_size, overwrite=True):
            chain.step(duration)

    times = interleaved({"plain": plain, "recorded": recorded}, rounds)
    share = 100.0 * (1.0 - ratio(times["plain"], times["recorded"]))
    note = f"{frames} frames in {steps} steps, {float(np.median(times['plain'])):.2f} s unrecorded; {_megabytes(path)}"
    return Figure(f"recording's share of a run, {grains} grains", share, "%", at_most=5.0, note=note)


def _megabytes(path: Any) -> str:
    return f"a log of {path.stat().st_size / 1e6:.0f} MB"
