"""Policies: callables (observation, info) -> action; `reset` clears their memory before an episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..components.support.float_arrays import FloatArray


class Policy(Protocol):
    """The interface of everything that chooses actions: drives, baselines, trained agents."""

    def reset(self) -> None:
        """Forget the last episode."""

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.ArrayLike:
        """Return the next action."""
        ...


class OpenLoop:
    """A drive: given actions in sequence, whatever is observed; zero after the last.

    Args:
        drive: numbers from -1 to 1, shape (steps, entries of an action), or (steps,) for one entry.
    """

    def __init__(self, drive: npt.ArrayLike) -> None:
        rows = np.array(drive, dtype=np.float64)
        self.drive: FloatArray = rows[:, None] if rows.ndim == 1 else rows
        self.step = 0

    def reset(self) -> None:
        """Start again with the first action of the drive."""
        self.step = 0

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the next action of the drive."""
        self.step += 1
        return self.drive[self.step - 1].copy() if self.step <= len(self.drive) else np.zeros(self.drive.shape[1])


class Constant(OpenLoop):
    """The same action at every step.

    Args:
        action: its entries, from -1 to 1.
    """

    def __init__(self, action: npt.ArrayLike = 0.0) -> None:
        super().__init__(np.atleast_2d(action))

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the action."""
        return self.drive[0].copy()


def play(
    env: Any, policy: Policy, *, seed: int | None = None, options: dict[str, Any] | None = None
) -> tuple[float, Mapping[str, Any]]:
    """Play one episode from reset to end; return the sum of its rewards and the last ``info``.

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
