"""What the tasks on a chain are made of alike: the driven end, the time there is, Hertz contacts, lists of numbers."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain.laws.functions import ENERGY_ROOT
from granular_env.components.chain.laws.law import lacks
from granular_env.components.errors import ParameterError, nearest, shortened
from granular_env.components.support.validation import positive_number

from ..envs.domain_randomization import make_chain

# What an agent may drive an end with: the end that it needs, the input, and its value at action 1 [N or m/s].
ACTIONS = {"force": ("free", "force", 1000.0), "piston": ("piston", "velocity", 10.0)}
# What every environment of these tasks observes as 1, and the chain's own idea of a large speed [m, m/s, m/s].
_DISPLACEMENT, _VELOCITY = 1e-3, 10.0
# Readings of the clock where it is on by default.
CLOCK = 8


def driven_chain(
    side: str,
    action: Any,
    action_scale: float | None,
    parameters: Mapping[str, Any],
    chain: Mapping[str, Any] | None,
    options: Mapping[str, Any],
) -> tuple[Chain, dict[str, float]]:
    """Return a chain whose end `side` the agent holds, and the task's `actions`.

    Args:
        side: "left" or "right".
        action: "force" on a free end grain, or "piston", the end grain's velocity.
        action_scale: force [N] or velocity [m/s] at action 1; None for 1000 N, 10 m/s.
        parameters: of the chain.
        chain: further ones, which count more.
        options: of the environment.

    Raises:
        ParameterError: the action is unknown, or an argument of the chain is not valid.
    """
    if not isinstance(action, str) or action not in ACTIONS:
        raise ParameterError(f"action: got {shortened(action)}; {nearest(str(action), ACTIONS)}")
    boundary, quantity, scale = ACTIONS[action]
    number = scale if action_scale is None else positive_number("action_scale", action_scale)
    given = {"velocity_scale": _VELOCITY, **without_none(parameters), side: boundary}
    return make_chain(given, chain, options.get("randomise")), {f"{side}_{quantity}": number}


def without_none(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that are not None; for the others the chain's own defaults hold, or what its arrangement says."""
    return {name: value for name, value in parameters.items() if value is not None}


def observation_scales() -> dict[str, float]:
    """Return the scales of what is observed."""
    return {"displacement": _DISPLACEMENT, "velocity": _VELOCITY}


def timing(
    options: Mapping[str, Any], internal_steps: int, deadline: int, clock: int = 0, endless: bool = False
) -> tuple[dict[str, Any], int, int]:
    """Return an environment's options with these defaults, the internal steps of a control step, and the control steps.

    The clock is on by default where a task's goal has a time.

    Raises:
        ParameterError: a count is none; without a deadline (0 steps) only where the task may be `endless`.
    """
    merged = {"internal_steps": internal_steps, "deadline": deadline, "clock": clock, **options}
    if endless and merged["deadline"] is None:
        return {**merged, "clock": options.get("clock", 0)}, timing({**options, "deadline": 1}, internal_steps, 1)[1], 0
    counts = [merged["internal_steps"], merged["deadline"]]
    for name, count in zip(("internal_steps", "deadline"), counts, strict=True):
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
            raise ParameterError(f"{name}: got {shortened(count)}, expected a whole number from 1")
    return merged, int(counts[0]), int(counts[1])


def hertz_chain(task: str, chain: Chain) -> tuple[float, float, float]:
    """Mean mass of the grains [kg], and stiffness [N/m^1.5] and overlap at rest [m] of the contacts between them.

    Raises:
        ParameterError: the contacts are not Hertz's, with or without dissipation, or there is none between grains.
    """
    law, geometry = chain.parameters.law, chain.geometry
    if lacks(type(law), ENERGY_ROOT) or chain.parameters.grains < 2:
        raise ParameterError(f"chain: task {task!r} wants at least 2 grains and Hertz contacts, got law {law.name!r}")
    inner = slice(1, chain.parameters.grains)
    # Overlaps at rest that differ from contact to contact (gravity, gaps) have no wave of their own: their mean stands for
    # them.
    rest = max(float(geometry.rest_overlap[inner].mean()), 0.0)
    return float(geometry.mass.mean()), float(geometry.stiffness[inner].mean()), rest


def numbers(name: str, given: Any) -> npt.NDArray[np.float64]:
    """Return a number, or several, as an array.

    Raises:
        ParameterError: it is neither, there is none, or one is not finite.
    """
    values = list(given) if isinstance(given, (Sequence, np.ndarray)) and not isinstance(given, str) else [given]
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise ParameterError(f"{name}: got {shortened(given)}, expected a number or a list of numbers")
    return array


def between(name: str, given: Any) -> tuple[float, float]:
    """Return a range (low, high), 0 < low <= high.

    Raises:
        ParameterError: it is none.
    """
    pair = numbers(name, given)
    if len(pair) != 2 or not 0.0 < pair[0] <= pair[1]:
        raise ParameterError(f"{name}: got {shortened(given)}, expected (low, high) with 0 < low <= high")
    return float(pair[0]), float(pair[1])


def whole(name: str, given: Any, most: int) -> int:
    """Return a whole number from 1 to `most`.

    Raises:
        ParameterError: it is none.
    """
    if isinstance(given, bool) or not isinstance(given, (int, np.integer)) or not 1 <= given <= most:
        raise ParameterError(f"{name}: got {shortened(given)}, expected a whole number from 1 to {most}")
    return int(given)


# What an agent sees is no part of the problem that a drive solves.
_SEEN = {"self", "chain", "options", "observe", "noise", "info", "clock", "render_mode", "step_error_reward", "action_scale"}
# What the chain itself takes where an environment's argument is None.
_CHAIN_DEFAULTS = {"radius": 3e-3, "material": "steel"}


def arguments_off_default(environment: Callable[..., Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Which arguments of an environment's factory differ from their defaults, name -> value: the problem's name.

    Args:
        environment: the factory.
        given: the local variables at its beginning.
    """
    defaults = {name: one.default for name, one in inspect.signature(environment).parameters.items()}
    defaults |= {name: value for name, value in _CHAIN_DEFAULTS.items() if name in defaults}
    given = {**given, **{name: value for name, value in _CHAIN_DEFAULTS.items() if given.get(name) is None}}
    chain = given["chain"] if isinstance(given["chain"], Mapping) else {}  # what is none is refused where the chain is made
    values = {**{name: given[name] for name in defaults if name in given}, **given["options"], **chain}
    return {name: one for name, one in values.items() if name not in _SEEN and not _same(one, defaults.get(name))}


def _same(one: Any, default: Any) -> bool:
    return type(one) in (int, float, str, type(None)) and one == default
