"""Speed-up from several processes: a sweep of tasks of about 0.1 s, relative to sequential execution."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from granular_env.sweep import run_sweep

from .figures import Figure
from .timing import call_seconds, median_ratio, time_interleaved

_WORKERS = 2


def measure(
    tasks: int = 100, task_seconds: float = 0.1, rounds: int = 3, least_tasks: int = 2000, uncounted: int = 1
) -> Iterator[Figure]:
    """Measure the speed-up for tasks of a given length, and for the shortest tasks including process start-up."""
    with TemporaryDirectory() as folder:
        place = Path(folder)
        duration = _choose_duration(place, task_seconds)
        plan = _plan(tasks, duration)
        begin = _plan(_WORKERS, 5e-8)
        calls = {engine: lambda engine=engine: _run_sweep(plan, place, engine) for engine in ("serial", "processes")}
        calls |= {
            f"{engine} begins": lambda engine=engine: _run_sweep(begin, place, engine) for engine in ("serial", "processes")
        }
        times = time_interleaved(calls, rounds, wall=True, uncounted=uncounted)
        steady = {engine: times[engine] - times[f"{engine} begins"] for engine in ("serial", "processes")}
        each = float(np.median(steady["serial"])) / tasks * 1e3
        start = float(np.median(times["processes begins"] - times["serial begins"]))
        note = f"{tasks} tasks of {each:.0f} ms, after starting the processes, which takes {start:.1f} s"
        yield Figure(
            f"{_WORKERS} processes / sequential execution",
            median_ratio(steady["serial"], steady["processes"]),
            at_least=1.7,
            note=note,
        )
        small = _plan(least_tasks, 2e-6)
        times = time_interleaved(
            {engine: lambda engine=engine: _run_sweep(small, place, engine) for engine in ("serial", "processes")},
            rounds,
            wall=True,
            uncounted=uncounted,
        )
        note = f"{least_tasks} of {float(np.median(times['serial'])) / least_tasks * 1e3:.2f} ms, including process start"
        yield Figure(f"{_WORKERS} processes, the smallest tasks", median_ratio(times["serial"], times["processes"]), note=note)


def _plan(tasks: int, duration: float) -> dict:
    return {
        "version": 1,
        "experiment": "nesterenko-1983/3.1-one-grain",
        "every": duration,
        "set": {"duration": duration, "component.step_size": 5e-8},
        "grid": {"start.velocity.0": {"from": 0.5, "to": 1.0, "count": tasks}},
        "measure": {"peak": "max velocity", "residual": "final energy_residual"},
    }


def _run_sweep(plan: dict, folder: Path, engine: str) -> None:
    """Run the whole sweep in a new folder."""
    workers = _WORKERS if engine == "processes" else None
    with TemporaryDirectory(dir=folder) as fresh:
        assert run_sweep(plan, Path(fresh) / "sweep", engine=engine, workers=workers).failed == 0


def _choose_duration(folder: Path, wanted: float) -> float:
    """Return the simulated time that takes `wanted` seconds to compute, a whole number of steps [s]."""
    tried = 1e-3
    _run_sweep(_plan(2, tried), folder, "serial")
    spent = min(call_seconds(lambda: _run_sweep(_plan(9, tried), folder, "serial"), wall=True) for _ in range(3)) / 9
    return max(1, round(tried * wanted / spent / 5e-8)) * 5e-8
