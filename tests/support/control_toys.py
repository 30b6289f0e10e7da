"""A problem without physics for the tests of studies: its best drive is known, and so are its slopes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from granular_env.control.drive import Drive
from granular_env.control.problem import Episode

TARGET = 0.5


class Bowl:
    """return = -mean((drive - target)^2) - (the episode's own shift), the target rising from 0 to `TARGET`.

    Args:
        broken_at: which evaluation returns NaN.
        pause: how long an evaluation takes [s].
    """

    stage: Mapping[str, object] | None = None
    steps, entries, observed, rate, gradient_runs = 20, 1, 3, None, 4.0

    def __init__(self, broken_at: int | None = None, pause: float = 0.0) -> None:
        self.asked, self.broken_at, self.pause = 0, broken_at, pause
        self.target = np.linspace(0.0, TARGET, self.steps)[:, None]

    def _value(self, drive: np.ndarray) -> float:
        self.asked += 1
        time.sleep(self.pause)
        return float("nan") if self.asked == self.broken_at else -float(np.mean((drive - self.target) ** 2))

    def returns(self, drives: np.ndarray, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        return np.array([self._value(drive) for drive in drives]), np.full(len(drives), self.steps * len(seeds))

    def policy_returns(self, policies: Callable, members: int, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        batch = policies(len(seeds))
        batch.reset()
        actions = np.stack([batch(self._seen(step, members * len(seeds))) for step in range(self.steps)], axis=1)
        values = np.array([self._value(drive) for drive in actions]).reshape(members, len(seeds)).mean(axis=1)
        return values, np.full(members, self.steps * len(seeds))

    def _seen(self, step: int, count: int) -> np.ndarray:
        return np.tile([step / self.steps, 1.0, -1.0], (count, 1))

    def value_and_grad(self, drive: np.ndarray, seeds: Sequence[int]) -> tuple[float, np.ndarray]:
        return -self._value(drive), 2.0 * (drive - self.target) / self.steps

    def baselines(self) -> Mapping[str, Drive]:
        return {"nothing": Drive(np.zeros((self.steps, 1))), "theory": Drive(np.full((self.steps, 1), 0.5 * TARGET))}

    def play(self, actor, seed: int, log: Path | None = None) -> Episode:
        actor.reset()
        actions = np.stack([np.ravel(actor(self._seen(step, 1)[0], {})) for step in range(self.steps)])
        if log is not None:
            log.write_text("a log")
        value = -float(np.mean((actions - self.target) ** 2))
        return Episode(value, actions, 1e-6, {"target [1]": self.target[:, 0]}, {"farthest": float(actions.max())})


def bowl_study(*methods: Mapping, **changes) -> dict:
    """The content of a study file for it."""
    chosen = list(methods) or [{"type": "random"}]
    return {"version": 1, "name": "bowl", "budget": 4000, "task": {"name": "force"}, "drive": {"knots": 4}, **changes} | {
        "method": chosen
    }
