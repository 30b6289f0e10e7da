"""A chain of which an agent holds one end until a deadline: what all tasks but that of the piston are made of."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from granular_env.components.chain import Chain
from granular_env.components.chain.laws.law import lacks
from granular_env.components.chain.laws.placeholders import ENERGY_ROOT
from granular_env.components.errors import ParameterError, nearest, one_line
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import positive_number, whole_number

from ..envs.domain_randomization import make_chain
from ..envs.environment import ChainEnv
from ..envs.task import ChainTask
from .arguments import without_none

# What an agent may drive an end with: the end that it needs, the input, and its value at action 1 [N or m/s].
ACTIONS = {"force": ("free", "force", 1000.0), "piston": ("piston", "velocity", 10.0)}
# What is observed as 1, and the chain's own idea of a large speed [m, m/s, m/s].
_DISPLACEMENT, _VELOCITY = 1e-3, 10.0
# Readings of the clock where it is on by default.
CLOCK = 8


@dataclass(frozen=True)
class DrivenEnd:
    """A chain, and what its environment lets an agent do and see.

    Attributes:
        chain: the component.
        actions: input -> its value at action 1 [N or m/s].
        observations: output -> its value observed as 1 [m or m/s].
        duration: of a control step [s].
        steps: control steps until the deadline, 0 for none.
        options: of the environment.
        arguments: of the environment, those that are not its defaults; they tell whether a best drive is known.
    """

    chain: Chain
    actions: Mapping[str, float]
    observations: Mapping[str, float]
    duration: float
    steps: int
    options: Mapping[str, Any]
    arguments: Mapping[str, Any]

    def environment(self, task: Callable[[Chain], ChainTask]) -> ChainEnv:
        """Return the environment of a task, which is made for each chain that is drawn."""
        return ChainEnv(self.chain, task, **self.options)


class DrivenEndTask(ChainTask):
    """Base of the tasks at a driven end.

    Args:
        chain: the driven chain of this episode.
        end: its driven end.

    Attributes:
        grains: number of grains.
        duration: of a control step [s].
        steps: control steps until the deadline, 0 for none.
        arguments: of the environment, those that are not its defaults; they tell whether a best drive is known.
    """

    def __init__(self, chain: Chain, end: DrivenEnd) -> None:
        self.grains, self.actions, self.observations = chain.parameters.grains, end.actions, end.observations
        self.duration, self.steps, self.arguments = end.duration, end.steps, end.arguments


def driven_end(
    make: Callable[..., Any],
    given: Mapping[str, Any],
    side: str,
    internal_steps: int,
    deadline: int,
    *,
    clock: int = CLOCK,
    endless: bool = False,
    scales: Mapping[str, float] | None = None,
    **parameters: Any,
) -> DrivenEnd:
    """Return the driven end of an environment's chain.

    Args:
        make: the environment's factory.
        given: its arguments: the local variables at its beginning.
        side: "left" or "right".
        internal_steps: default, of a control step.
        deadline: default, in control steps.
        clock: default, readings of it.
        endless: whether there may be no deadline (None).
        scales: action -> force [N] or velocity [m/s] at action 1 where `action_scale` is None.
        parameters: further ones of the chain.

    Raises:
        ParameterError: the action or a count is none, or an argument of the chain is not valid.
    """
    options = {"internal_steps": internal_steps, "deadline": deadline, "clock": clock, **given["options"]}
    if endless and options["deadline"] is None:
        options["clock"] = given["options"].get("clock", 0)
    chosen = {name: given[name] for name in ("grains", "radius", "material", "step_size")}
    chain, actions = _driven_chain(side, given, {**chosen, **parameters}, scales or {})
    return DrivenEnd(
        chain,
        actions,
        {"displacement": _DISPLACEMENT, "velocity": parameters.get("velocity_scale", _VELOCITY)},
        whole_number("internal_steps", options["internal_steps"]) * chain.step_size,
        0 if endless and options["deadline"] is None else whole_number("deadline", options["deadline"]),
        options,
        _off_default(make, given),
    )


def _driven_chain(
    side: str, given: Mapping[str, Any], parameters: Mapping[str, Any], scales: Mapping[str, float]
) -> tuple[Chain, dict[str, float]]:
    action, scale = given["action"], given["action_scale"]
    if not isinstance(action, str) or action not in ACTIONS:
        raise ParameterError(f"got {one_line(action)}", hint=nearest(str(action), ACTIONS), at="action")
    boundary, quantity, usual = ACTIONS[action]
    number = scales.get(action, usual) if scale is None else positive_number("action_scale", scale)
    own = {"velocity_scale": _VELOCITY, **without_none(parameters), side: boundary}
    return make_chain(own, given["chain"], given["options"].get("randomise")), {f"{side}_{quantity}": number}


def hertz_chain(task: str, chain: Chain) -> tuple[float, float, float]:
    """Return the grains' mean mass [kg], and stiffness [N/m^1.5] and overlap at rest [m] of the contacts between them.

    Raises:
        ParameterError: the contacts are not Hertz's, with or without dissipation, or there is none between grains.
    """
    law, geometry = chain.parameters.law, chain.geometry
    if chain.parameters.grains < 2:
        raise ParameterError(f"got {chain.parameters.grains}", expected="at least 2", at="grains", source=f"task {task!r}")
    if lacks(type(law), ENERGY_ROOT):
        raise ParameterError(f"got {law.name!r}", expected="Hertz contacts", at="chain.law", source=f"task {task!r}")
    inner = slice(1, chain.parameters.grains)
    # Overlaps at rest that differ from contact to contact (gravity, gaps) have no wave of their own: their mean stands for
    # them.
    rest = max(float(geometry.rest_overlap[inner].mean()), 0.0)
    return float(geometry.mass.mean()), float(geometry.stiffness[inner].mean()), rest


@jit
def sum_value(sums, constants, slopes):
    """Return an objective that is one sum, with its slope."""
    slopes[0] = 1.0
    return sums[0]


# What an agent sees is no part of the problem that a drive solves.
_SEEN = {"self", "chain", "options", "observe", "noise", "info", "clock", "render_mode", "step_error_reward", "action_scale"}
# What the chain itself takes where an environment's argument is None.
_CHAIN_DEFAULTS = {"radius": 3e-3, "material": "steel"}


def _off_default(make: Callable[..., Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a factory that differ from their defaults, name -> value: the problem's name."""
    defaults = {name: one.default for name, one in inspect.signature(make).parameters.items()}
    defaults |= {name: value for name, value in _CHAIN_DEFAULTS.items() if name in defaults}
    given = {**given, **{name: value for name, value in _CHAIN_DEFAULTS.items() if given.get(name) is None}}
    chain = given["chain"] if isinstance(given["chain"], Mapping) else {}  # what is none is refused where the chain is made
    values = {**{name: given[name] for name in defaults if name in given}, **given["options"], **chain}
    return {name: one for name, one in values.items() if name not in _SEEN and not _same(one, defaults.get(name))}


def _same(one: Any, default: Any) -> bool:
    return type(one) in (int, float, str, type(None)) and one == default
