"""Policies: callables (observation, info) -> action with a memory that `reset` clears."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray

from ..components.errors import ParameterError, one_line


class Policy(Protocol):
    """A chooser of actions: a callable with a memory that `reset` clears."""

    def reset(self) -> None:
        """Begin an episode."""

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.ArrayLike:
        """Return the next action."""
        ...


class Constant:
    """The same action at every step.

    Args:
        action: numbers from -1 to 1; zero is doing nothing.
    """

    def __init__(self, action: npt.ArrayLike = 0.0) -> None:
        self.action = _actions("action", np.atleast_1d(np.asarray(action)), 1)

    def reset(self) -> None:
        """Do nothing: there is no memory."""

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the action."""
        return self.action.copy()


class OpenLoop:
    """A drive that looks at nothing: its rows one after the other, then zero.

    Args:
        drive: shape (steps, actions) or (steps,), from -1 to 1.
    """

    def __init__(self, drive: npt.ArrayLike) -> None:
        rows = np.asarray(drive)
        self.drive = _actions("drive", rows[:, None] if rows.ndim == 1 else rows, 2)
        self.step = 0

    def reset(self) -> None:
        """Begin with the first row again."""
        self.step = 0

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the next row."""
        self.step += 1
        if self.step > len(self.drive):
            return np.zeros(self.drive.shape[1])
        return self.drive[self.step - 1].copy()


def _actions(name: str, given: npt.NDArray[Any], dimensions: int) -> FloatArray:
    if given.ndim != dimensions or given.dtype.kind not in "fiu" or not np.all(np.isfinite(given)):
        raise ParameterError(f"got {one_line(given)}", expected="finite numbers from -1 to 1", at=name)
    return np.ascontiguousarray(given, dtype=np.float64)


def play(
    env: Any, policy: Policy, *, seed: int | None = None, options: dict[str, Any] | None = None
) -> tuple[float, Mapping[str, Any]]:
    """One episode, from its reset to its end; the return, and the last ``info``.

    Args:
        env: a Gymnasium environment.
        policy: chooses its actions.
        seed: of the reset.
        options: of the reset.
    """
    observation, info = env.reset(seed=seed, options=options)
    policy.reset()
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation, info))
        total, over = total + float(reward), terminated or truncated
    return total, info
