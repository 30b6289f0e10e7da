"""Cost of recording: per step from Python at 100 grains, and as a share of a long run at 100,000 grains."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

import granular_env as ge

from . import chains
from .figures import Figure
from .timing import median_ratio, time_interleaved

# 200 frames in 20,000 steps.
_FRAME_STEPS = 100


def measure(
    steps: int = 100_000, rounds: int = 5, long_grains: int = 100_000, long_steps: int = 10_000, long_rounds: int = 3
) -> Iterator[Figure]:
    """Measure both costs; the second for a run in pieces, as in `ge.run`, and for one long call of `step`."""
    with TemporaryDirectory() as folder:
        yield _measure_step(Path(folder) / "short.mcap", steps, rounds)
        yield from _measure_shares(Path(folder) / "long.mcap", long_grains, long_steps, long_rounds)


def _measure_step(path: Path, steps: int, rounds: int) -> Figure:
    """Measure calls of one internal step with a new input each, including opening and closing the log."""
    chain = chains.precompressed_chain(100, left="free")
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

    times = time_interleaved({"plain": plain, "recorded": recorded}, rounds, wall=True)
    cost = float(np.median(times["recorded"] - times["plain"])) / steps * 1e6
    opening = float(np.median(times["recorded"] - np.array(inside[1:]))) * 1e3
    bare = float(np.median(times["plain"])) / steps * 1e6
    note = f"{steps} steps of {bare:.2f} us each unrecorded; including opening and closing ({opening:.0f} ms in total)"
    return Figure("cost of recording a step, 100 grains, new input at each step", cost, "us", at_most=5.0, note=note)


def _measure_shares(path: Path, grains: int, steps: int, rounds: int) -> Iterator[Figure]:
    chain = chains.precompressed_chain(grains)
    start, frame, whole = chain.save(), _FRAME_STEPS * chain.step_size, steps * chain.step_size

    sizes = []

    def fresh() -> None:
        chain.restore(start)
        if path.exists():
            sizes.append(path.stat().st_size)
            path.unlink()

    def stepped(duration: float) -> None:
        for _ in range(round(whole / duration)):
            chain.step(duration)

    def recorded(duration: float) -> None:
        with ge.record(chain, path, every=frame):
            stepped(duration)

    lengths = {"in pieces": frame, "in one call": whole}
    plain = {f"{name}, unrecorded": partial(stepped, length) for name, length in lengths.items()}
    times = time_interleaved(
        plain | {name: partial(recorded, length) for name, length in lengths.items()}, rounds, before=fresh, wall=True
    )
    size = float(np.median(sizes)) / 1e6
    frames = steps // _FRAME_STEPS
    for name in lengths:
        bare = times[f"{name}, unrecorded"]
        share, seconds = 100.0 * (1.0 - median_ratio(bare, times[name])), float(np.median(bare))
        a_frame = float(np.median(times[name] - bare)) / frames * 1e3
        note = f"{frames} frames in {steps} steps, {seconds:.1f} s unrecorded; {a_frame:.1f} ms per frame, log of {size:.0f} MB"
        yield Figure(f"recording's share of a run {name}, {grains} grains", share, "%", at_most=5.0, note=note)
