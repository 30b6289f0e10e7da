"""Time of `replay --verify` relative to the run that it repeats, recorded in the same way."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import granular_env as ge

from . import chains
from .figures import Figure
from .timing import Call, median_ratio, time_interleaved


def measure(grains: int = 8000, steps: int = 100_000, rounds: int = 3) -> Iterator[Figure]:
    """Measure a long run in one call, and a run of many short calls."""
    with TemporaryDirectory() as folder:
        yield _measure_piston(Path(folder) / "piston.mcap", grains, rounds)
        yield _measure_driven_chain(Path(folder) / "driven.mcap", steps, rounds)


def _measure_piston(path: Path, grains: int, rounds: int) -> Figure:
    """Measure a longer version of experiment 3.4, whose front passes 100 grains in 5.45e-4 s."""
    frame = 1e-6 * max(1, round(grains / 40))
    duration = frame * max(1, round(grains * 5.45e-6 / frame))
    changes = {"component.grains": grains, "duration": float(f"{duration:.9g}"), "record.every": float(f"{frame:.9g}")}

    def live() -> None:
        ge.run("nesterenko-1983/3.4-piston", log=path, overrides=changes, overwrite=True)

    return _compare_verification(live, path, rounds, f"replay --verify / live, 3.4 with {grains} grains")


def _measure_driven_chain(path: Path, steps: int, rounds: int) -> Figure:
    chain = chains.precompressed_chain(100, left="free")
    start = chain.save()
    forces = np.random.default_rng(4).uniform(-1.0, 1.0, steps).tolist()

    def live() -> None:
        chain.restore(start)
        with ge.record(chain, path, overwrite=True):
            for force in forces:
                chain.step(left_force=force)

    return _compare_verification(live, path, rounds, f"the same, 100 grains, {steps} steps with a new input at each step")


def _compare_verification(live: Call, path: Path, rounds: int, what: str) -> Figure:
    results = []
    times = time_interleaved({"live": live, "verify": lambda: results.append(ge.verify(path))}, rounds, wall=True)
    if not all(result.identical for result in results):
        raise AssertionError(f"{what}: {results[-1].message}")
    seconds = {name: float(np.median(values)) for name, values in times.items()}
    done = f"{results[-1].ticks} internal steps, {results[-1].frames} frames"
    note = f"live {seconds['live']:.2f} s, verified in {seconds['verify']:.2f} s; {done}"
    return Figure(what, median_ratio(times["live"], times["verify"]), at_least=0.5, note=note)
