"""A problem without physics for tests of studies, with known optimal drive and slopes."""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from granular_env.envs import OpenLoop

TARGET = 0.5


class Bowl:
    """A problem with return = -mean((drive - target)^2); the target rises from 0 to `TARGET`.

    Args:
        broken_at: number of the evaluation that returns NaN.
        sent: signal that this process sends to itself at evaluation `sent_at`.
    """

    stage: Mapping[str, object] | None = None
    steps, duration, entries, rate, gradient_runs, task_source = 20, 1e-6, 1, None, 4.0, ""

    def __init__(self, broken_at: int | None = None, sent: int | None = None, sent_at: int | None = None) -> None:
        self.asked, self.broken_at, self.sent, self.sent_at = 0, broken_at, sent, sent_at
        self.target = np.linspace(0.0, TARGET, self.steps)[:, None]

    def _value(self, drive: np.ndarray) -> float:
        self.asked += 1
        if self.asked == self.sent_at:
            signal.raise_signal(self.sent)
        return float("nan") if self.asked == self.broken_at else -float(np.mean((drive - self.target) ** 2))

    def returns(self, drives: np.ndarray, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        return np.array([self._value(drive) for drive in drives]), np.full(len(drives), self.steps * len(seeds))

    def value_and_grad(self, drive: np.ndarray, seeds: Sequence[int]) -> tuple[float, np.ndarray]:
        return -self._value(drive), 2.0 * (drive - self.target) / self.steps

    def baselines(self) -> Mapping[str, OpenLoop]:
        return {"nothing": OpenLoop(np.zeros((self.steps, 1))), "theory": OpenLoop(np.full((self.steps, 1), 0.5 * TARGET))}

    def play_episode(self, actor, seed: int, log: Path | None = None) -> tuple[float, np.ndarray]:
        actor.reset()
        actions = np.stack([np.ravel(actor(np.zeros(1), {})) for step in range(self.steps)])
        if log is not None:
            log.write_text("a log")
        return -float(np.mean((actions - self.target) ** 2)), actions


def bowl_study(*methods: Mapping, **changes) -> dict:
    """Return the content of a study file for the problem."""
    chosen = list(methods) or [{"type": "random"}]
    return {"version": 1, "name": "bowl", "budget": 4000, "task": {"name": "force"}, "drive": {"knots": 4}, **changes} | {
        "method": chosen
    }
