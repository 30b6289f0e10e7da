"""What `step`, `save` and `restore` of 64 grains cost from Python, and what the undo costs one-tick calls of larger chains."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from . import chains
from .figures import Figure
from .timing import Times, interleaved, microseconds, ratio


def measure(calls: int = 2000, rounds: int = 101) -> Iterator[Figure]:
    """The median of each round's difference, so that a loaded machine disturbs both sides alike."""
    chain = chains.pressed(64, left="free")
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

    physics = lambda: chain._advance(calls)  # noqa: E731
    times = interleaved({"step": step, "physics": physics, "snapshot": snapshot, "empty": empty}, rounds)
    yield from _figures(times, calls)
    for grains in (200, 300, 1200, 5000, 20_000):
        yield _undo_figure(grains, max(calls * 200 // grains, 20), rounds)


class _NoUndo:
    """An undo that does nothing."""

    is_small, counts_arrays, until, limit = False, True, -1, 0
    steps: tuple[()] = ()

    def prepare(self, tick: int) -> None: ...
    def note(self, ticks: int, held: object) -> None: ...
    def forget(self) -> None: ...


def _undo_figure(grains: int, calls: int, rounds: int) -> Figure:
    # One chain for both, as where a state lies in memory costs it some percents.
    chain = chains.pressed(grains, left="free")
    undo, none = chain._undo, _NoUndo()

    def steps(present: Any) -> None:
        chain._undo = present
        for _ in range(calls):
            chain.step(left_force=1.0)

    def nothing() -> None:
        for _ in range(calls):
            none.prepare(0)
            none.note(1, {})

    # What the steps without an undo call in its place is no part of a step.
    times = interleaved({"with": lambda: steps(undo), "without": lambda: steps(none), "nothing": nothing}, rounds)
    share = 100.0 * (1.0 - 1.0 / ratio(times["with"], times["without"] - times["nothing"]))
    note = f"a call {microseconds(times['with'], calls):.2f} us, a state of {chain.state_bytes / 1024:.0f} KB"
    return Figure(f"undo in one-tick calls, {grains} grains", share, "%", at_most=5.0, note=note)


def _figures(times: Times, calls: int) -> Iterator[Figure]:
    step, physics, snapshot, empty = (microseconds(times[name], calls) for name in ("step", "physics", "snapshot", "empty"))
    beyond = microseconds(times["step"] - times["physics"], calls)
    note = f"step {step:.2f} us, physics {physics:.3f} us, an empty call {empty:.3f} us: {beyond / empty:.1f} empty calls"
    yield Figure("step(left_force=x) beyond its physics, 64 grains", beyond, "us", at_most=1.0, note=note)
    note = f"{snapshot / physics:.1f} times the physics of a step, {snapshot / empty:.1f} empty calls"
    yield Figure("restore(save()), 64 grains", snapshot, "us", at_most=1.0, note=note)
