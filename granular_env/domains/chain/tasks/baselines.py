"""The policies that every task is compared with, made of drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from granular_env.envs.policies import Constant, OpenLoop, Policy

from .best_drives import best_drive


class _Driven(Protocol):
    hold: int
    actions: Mapping[str, float]
    arguments: Mapping[str, Any]


def open_loops(task: _Driven, environment: str, theory: npt.NDArray[np.float64]) -> dict[str, Policy]:
    """Doing nothing, "theory" and, where one is known that the scale admits, "best".

    Args:
        task: with one action.
        environment: its registered name.
        theory: the input in each control step [N or m/s], shape (steps,).
    """
    scale = next(iter(task.actions.values()))
    best = best_drive(environment, task.arguments)
    policies: dict[str, Policy] = {"nothing": Constant(0.0), "theory": OpenLoop(hold_mean(theory, task.hold) / scale)}
    return policies if best is None or np.abs(best).max(initial=0.0) > scale else {**policies, "best": OpenLoop(best / scale)}


def hold_mean(drive: npt.NDArray[np.float64], hold: int) -> npt.NDArray[np.float64]:
    """Return the mean of a drive over each action that is held for `hold` control steps, shape (actions,)."""
    if hold == 1:
        return drive
    places = np.arange(0, len(drive), hold)
    return np.add.reduceat(drive, places) / np.diff(np.append(places, len(drive)))
