"""Policies: callables (observation, info) -> action with a memory that `reset` clears."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..components.errors import ParameterError, shortened

FloatArray = npt.NDArray[np.float64]


class Constant:
    """The same action at every step.

    Args:
        action: numbers from -1 to 1; zero is doing nothing.
    """

    def __init__(self, action: npt.ArrayLike = 0.0) -> None:
        self.action = _actions("action", np.atleast_1d(np.asarray(action)), 1)

    def reset(self) -> None:
        """There is no memory."""

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """The action."""
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
        """From the first row."""
        self.step = 0

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """The next row."""
        self.step += 1
        if self.step > len(self.drive):
            return np.zeros(self.drive.shape[1])
        return self.drive[self.step - 1].copy()


def _actions(name: str, given: npt.NDArray[Any], dimensions: int) -> FloatArray:
    if given.ndim != dimensions or given.dtype.kind not in "fiu" or not np.all(np.isfinite(given)):
        raise ParameterError(f"{name}: got {shortened(given)}, expected finite numbers from -1 to 1")
    return np.ascontiguousarray(given, dtype=np.float64)
