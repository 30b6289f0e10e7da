"""Tasks: the actions of an agent, its observations and its rewards.

A task knows a component only by its contract, and knows nothing of Gymnasium. Tasks live one a file in ``tasks/``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from ..components.component import Component
from ..components.errors import ParameterError, one_line
from .policies import Policy

Seen = Mapping[str, npt.NDArray[np.float64]]
"""The observed outputs, unscaled, name -> value."""


class Task(ABC):
    """Base of every task.

    Attributes:
        name: for messages and pictures.
        actions: input, or an element of one such as "force[3,0]" -> its value at action 1, in the unit of the input; action -1
            is the opposite. The order is that of the action's entries.
        observations: output, or an element of one -> its value that is observed as 1, in the unit of the output. The order is
            that of the observation's parts.
        observation_limit: observations are clipped to +- this.
        counters: what the task itself remembers of the episode, name -> number. It is saved and restored with the environment
            and shown in ``info``.
    """

    name: ClassVar[str]
    actions: Mapping[str, float]
    observations: Mapping[str, float]
    observation_limit: float = 10.0

    def __init__(self) -> None:
        self.counters: dict[str, float] = {}

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Start values for `Component.reset`; the default is the component's own start."""
        return {}

    @abstractmethod
    def begin(self, component: Component, seen: Seen) -> None:
        """Set the counters at the start of an episode."""

    @abstractmethod
    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Reward of a control step that lasted `duration` [s], and whether the episode has reached its end."""

    def baselines(self) -> Mapping[str, Policy]:
        """Return policies to compare with, by name: "nothing", "theory" (made by hand), "best" (best known); here none."""
        return {}


def validate_judgement(task: Task, given: Any) -> tuple[float, bool]:
    """Return what `Task.judge` returned, after validation.

    Raises:
        ParameterError: it is not (reward, done), or the reward is not finite.
    """
    try:
        reward, done = given
        number = float(reward)
    except (TypeError, ValueError):
        raise ParameterError(f"task {task.name!r}: judge gave {one_line(given)}", expected="(reward, done)") from None
    if not math.isfinite(number):
        raise ParameterError(f"task {task.name!r}: its reward is {number}", hint="mend its judge")
    return reward, bool(done)


def refuse_incomplete(task: Any) -> None:
    """Refuse what lacks one of the attributes that every task has.

    Raises:
        ParameterError: it is no task, or an attribute is missing; names it.
    """
    if not isinstance(task, Task):
        raise ParameterError(f"got {one_line(task)}", expected="an object of a class made from Task", at="task")
    for name, example in (("name", '"swing"'), ("actions", '{"left_force": 100.0}'), ("observations", '{"velocity": 1.0}')):
        if getattr(task, name, None) is None:
            raise ParameterError(
                f"{type(task).__name__} has no {name}", hint=f"give it one, such as {name} = {example}", at="task"
            )
        if name != "name" and not isinstance(getattr(task, name), Mapping):
            raise ParameterError(
                f"got {one_line(getattr(task, name))}", expected=f"a mapping, such as {example}", at=f"task.{name}"
            )
