"""Control steps per second of the native batch, relative to its physics alone and to SyncVectorEnv; cost of snapshots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

import granular_env.envs  # noqa: F401 - registers the environments

from .figures import Figure
from .timing import median_ratio, microseconds, time_interleaved

NAME, COUNT, GRAINS = "granular_env/Protection-v1", 256, 64


def measure(steps: int = 20, rounds: int = 41) -> Iterator[Figure]:
    """Measure with full-state observation and 3 PEFRL steps (12 force evaluations) per control step, including resets."""
    native = gymnasium.make_vec(NAME, num_envs=COUNT, grains=GRAINS)
    single = gymnasium.make_vec(NAME, num_envs=COUNT, grains=GRAINS, vectorization_mode="sync", info="brief")
    chosen = np.random.default_rng(3).uniform(0.0, 0.4, (steps, COUNT, 1)).astype(np.float32)
    for env in (native, single):
        env.reset(seed=1)
        for _ in range(10):  # let waves enter all chains
            for actions in chosen:
                env.step(actions)
    bare, forces = _bare_physics(native), np.full(COUNT, 100.0)
    tables = native.unwrapped._rows.tables.copy()  # type: ignore[attr-defined]
    start = tables.copy()

    def batch() -> None:
        for actions in chosen:
            native.step(actions)

    def one_by_one() -> None:
        single.step(chosen[0])

    def physics() -> None:
        tables[:] = start
        for _ in range(steps):
            bare(tables, forces)

    times = time_interleaved({"batch": batch, "physics": physics, "sync": one_by_one}, rounds)
    yield from _rates(times, steps)
    yield _snapshots(rounds)


def _bare_physics(native: Any) -> Any:
    component, ticks = native.get_attr("component")[0], native.get_attr("internal_steps")[0]
    advance, rows = component.entries.advance_batch, component.state_rows
    kept = np.zeros((rows.stop - rows.start, component.table.shape[1]))

    def bare(tables: np.ndarray, forces: np.ndarray) -> None:
        inputs = np.column_stack([forces, np.zeros(COUNT)])
        advance(tables, inputs, np.zeros(COUNT, np.int64), ticks, np.ones(COUNT, np.bool_), kept, rows.start)

    bare(native.unwrapped._rows.tables.copy(), np.zeros(COUNT))
    return bare


def _rates(times: dict[str, np.ndarray], steps: int) -> Iterator[Figure]:
    rate = COUNT * steps / float(np.median(times["batch"]))
    best = COUNT * steps / float(np.min(times["batch"]))
    what = f"{COUNT} environments x {GRAINS} grains x 12 forces"
    yield Figure(f"{what}, million control steps/s", rate / 1e6, "M/s", at_least=1.5, note=f"best {best / 1e6:.2f} M/s")
    part = median_ratio(times["physics"], times["batch"])
    yield Figure("the same / direct calls of the integrator", part, at_least=0.5)
    yield Figure(
        "the same / SyncVectorEnv of single environments", steps * median_ratio(times["sync"], times["batch"]), at_least=10.0
    )


def _snapshots(rounds: int, calls: int = 2000) -> Figure:
    env: Any = gymnasium.make(NAME, grains=GRAINS).unwrapped
    env.reset(seed=1)
    env.step([0.5])

    def pair() -> None:
        for _ in range(calls):
            env.restore(env.save())

    times = time_interleaved({"pair": pair}, rounds)
    return Figure("restore(save()) of an environment, 64 grains", microseconds(times["pair"], calls), "us", at_most=3.0)
