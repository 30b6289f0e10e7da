"""Policies: callables (observation, info) -> action, with a memory that `reset` clears."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..components.support.float_arrays import FloatArray


class Policy(Protocol):
    """A chooser of actions: a drive, a baseline, a trained agent."""

    def reset(self) -> None:
        """Begin an episode."""

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.ArrayLike:
        """Return the next action."""
        ...


class OpenLoop:
    """A drive without feedback: its rows in sequence, then zero.

    Args:
        drive: shape (steps, actions) or (steps,), from -1 to 1.
    """

    def __init__(self, drive: npt.ArrayLike) -> None:
        rows = np.array(drive, dtype=np.float64)
        self.drive: FloatArray = rows[:, None] if rows.ndim == 1 else rows
        self.step = 0

    def reset(self) -> None:
        """Restart with the first row."""
        self.step = 0

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the next row."""
        self.step += 1
        return self.drive[self.step - 1].copy() if self.step <= len(self.drive) else np.zeros(self.drive.shape[1])


class Constant(OpenLoop):
    """The same action at every step.

    Args:
        action: numbers from -1 to 1; zero for no action.
    """

    def __init__(self, action: npt.ArrayLike = 0.0) -> None:
        super().__init__(np.atleast_2d(action))

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the action."""
        return self.drive[0].copy()


def play(
    env: Any, policy: Policy, *, seed: int | None = None, options: dict[str, Any] | None = None
) -> tuple[float, Mapping[str, Any]]:
    """Play one episode from reset to end; return its return and the last ``info``.

    Args:
        env: a Gymnasium environment.
        policy: policy that selects the actions.
        seed: seed of the reset.
        options: options of the reset.
    """
    observation, info = env.reset(seed=seed, options=options)
    policy.reset()
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation, info))
        total, over = total + float(reward), terminated or truncated
    return total, info
