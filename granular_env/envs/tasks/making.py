"""What the tasks on a chain are made of alike: their checked arguments, their chain, the end that the agent holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...components.catalogue import make
from ...components.chain import Chain, table
from ...components.errors import ParameterError, nearest, shortened
from ...components.profiles import positive_number

# What an agent may drive an end with: the end that it needs, the input, and its unit.
ACTIONS = {"force": ("free", "force"), "piston": ("piston", "velocity")}


def driven_chain(side: str, action: str, scale: float, parameters: dict[str, Any]) -> tuple[Chain, dict[str, float]]:
    """A chain whose end `side` the agent holds, and the task's `actions`.

    Args:
        side: "left" or "right".
        action: "force" on a free end grain, or "piston", the end grain's velocity.
        scale: force [N] or velocity [m/s] at action 1.
        parameters: of the chain.

    Raises:
        ParameterError: the action is unknown, or an argument of the chain is not valid.
    """
    if action not in ACTIONS:
        raise ParameterError(f"action: got {shortened(action)}, {nearest(str(action), ACTIONS)}")
    boundary, quantity = ACTIONS[action]
    chain: Any = make("chain", **{side: boundary, **parameters})
    return chain, {f"{side}_{quantity}": positive_number("action_scale", scale)}


def hertz_chain(task: str, chain: Chain) -> tuple[float, float, float]:
    """Mean mass of the grains [kg], and stiffness [N/m^1.5] and overlap at rest [m] of the contacts between them.

    Raises:
        ParameterError: the contacts are not Hertz's, with or without dissipation, or there is none between grains.
    """
    law, geometry = chain.parameters.law, chain.geometry
    if law.elastic != table.HERTZ or chain.parameters.grains < 2:
        raise ParameterError(f"chain: task {task!r} wants at least 2 grains and Hertz contacts, got law {law.name!r}")
    inner = slice(1, chain.parameters.grains)
    # An overlap at rest that differs from contact to contact (gravity, gaps) has no wave of its own: its mean stands for it.
    rest = max(float(geometry.rest_overlap[inner].mean()), 0.0)
    return float(geometry.mass.mean()), float(geometry.stiffness[inner].mean()), rest


def numbers_of(name: str, given: Any) -> list[float]:
    """A number, or several, as a list.

    Raises:
        ParameterError: it is neither, is empty, or a number is not finite.
    """
    values = list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.full(1, np.nan)
    if numbers.ndim != 1 or not len(numbers) or not np.all(np.isfinite(numbers)):
        raise ParameterError(f"{name}: got {shortened(given)}, expected a number or a list of numbers")
    return numbers.tolist()
