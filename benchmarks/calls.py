"""Cost of `step`, `save` and `restore` of 64 grains from Python, and of the state copy in one-tick calls."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from . import chains
from .figures import Figure
from .timing import Times, median_ratio, microseconds, time_interleaved


def measure(calls: int = 2000, rounds: int = 101) -> Iterator[Figure]:
    """Measure medians of the differences per round, so that load on the machine affects both sides equally."""
    chain = chains.precompressed_chain(64, left="free")
    forces = np.random.default_rng(2).uniform(-1.0, 1.0, calls).tolist()
    nothing = lambda **inputs: None  # noqa: E731

    def empty() -> None:
        for force in forces:
            nothing(left_force=force)

    def step() -> None:
        for force in forces:
            chain.step(left_force=force)

    def snapshot() -> None:
        for _ in forces:
            chain.restore(chain.save())

    physics = lambda: chain._advance_state(calls)  # noqa: E731
    times = time_interleaved({"step": step, "physics": physics, "snapshot": snapshot, "empty": empty}, rounds)
    yield from _figures(times, calls)
    for grains in (200, 300, 1200, 5000, 20_000):
        yield _copy_figure(grains, max(calls * 200 // grains, 20), rounds)


def _copy_figure(grains: int, calls: int, rounds: int) -> Figure:
    chain = chains.precompressed_chain(grains, left="free")
    block, step, copies = chain._block, chain.step_size, range(calls)

    def steps() -> None:
        for _ in copies:
            chain.step(step, left_force=1.0)

    def back_up() -> None:
        for _ in copies:
            block.back_up()

    times = time_interleaved({"steps": steps, "copies": back_up}, rounds)
    share = 100.0 * median_ratio(times["copies"], times["steps"])
    note = f"call: {microseconds(times['steps'], calls):.2f} us, state: {chain.state_bytes / 1024:.0f} KB"
    return Figure(f"cost of the state copy in one-tick calls, {grains} grains", share, "%", note=note)


def _figures(times: Times, calls: int) -> Iterator[Figure]:
    step, physics, snapshot, empty = (microseconds(times[name], calls) for name in ("step", "physics", "snapshot", "empty"))
    beyond = microseconds(times["step"] - times["physics"], calls)
    note = f"step {step:.2f} us, physics {physics:.3f} us, an empty call {empty:.3f} us: {beyond / empty:.1f} empty calls"
    yield Figure("step(left_force=x), overhead beyond the physics, 64 grains", beyond, "us", at_most=1.0, note=note)
    note = f"{snapshot / physics:.1f} times the physics of a step, {snapshot / empty:.1f} times an empty call"
    yield Figure("restore(save()), 64 grains", snapshot, "us", at_most=1.0, note=note)
