"""Tasks: the actions of an agent, its observations and its rewards.

A task knows a component only by its contract, and knows nothing of Gymnasium. Tasks live one a file in ``tasks/``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from ..components.component import Component
from ..components.errors import ParameterError, one_line
from ..domains import gradient_domains
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
        counters: what the task itself remembers of the episode, name -> number; empty before `begin`. The environment saves
            and restores them, and shows them in ``info``. Anything else that a task remembers is lost by `restore`;
            `check_task` finds it.
    """

    name: ClassVar[str]
    actions: Mapping[str, float]
    observations: Mapping[str, float]
    observation_limit: float = 10.0
    counters: dict[str, float]

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Start values for `Component.reset`; the default is the component's own start."""
        return {}

    @abstractmethod
    def begin(self, component: Component, seen: Seen) -> None:
        """Set the counters at the start of an episode."""

    @abstractmethod
    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Reward of a control step that lasted `duration` [s], and whether the episode has reached its end."""

    def objective(self, component: Any, steps: int) -> Any:
        """Return the smooth counterpart of minus the return, for gradients.

        Raises:
            ParameterError: this task has none.
        """
        raise no_objective(self)

    def baselines(self) -> Mapping[str, Policy]:
        """Return policies to compare with, by name: "nothing", "theory" (made by hand), "best" (best known); here none."""
        return {}


def no_objective(task: Task) -> ParameterError:
    """Return the error for a task without gradients."""
    return ParameterError(
        f"task {task.name!r} has no objective with a gradient",
        hint=f"use a method that needs none; components with gradients: {gradient_domains()}",
    )


def judgement(task: Task, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
    """Return the reward of a control step, and whether the task has ended; `Task.judge` gets `seen` read-only.

    Raises:
        ParameterError: `judge` did not return (reward, done), the reward is not finite, or it stepped the component.
    """
    tick = component.tick
    given = task.judge(component, read_only(seen), duration)
    try:
        reward, done = given
        number = float(reward)
    except (TypeError, ValueError):
        raise ParameterError(f"task {task.name!r}: judge gave {one_line(given)}", expected="(reward, done)") from None
    if not math.isfinite(number):
        raise ParameterError(f"task {task.name!r}: its reward is {number}", hint="mend its judge")
    if component.tick != tick:
        raise ParameterError(
            f"task {task.name!r}: its judge moved the component from tick {tick} to {component.tick}",
            hint="read the component with get(); ComponentEnv steps it",
        )
    return number, bool(done)


def read_only(seen: Seen) -> Seen:
    """Return the observed outputs as a mapping and arrays that refuse writes."""
    shown = dict(seen)
    for name, value in seen.items():
        if isinstance(value, np.ndarray):
            shown[name] = value.view()
            shown[name].flags.writeable = False
    return MappingProxyType(shown)


def counters(task: Task) -> dict[str, float]:
    """Return a copy of a task's counters.

    Raises:
        ParameterError: one of them is not a number.
    """
    try:
        return {name: float(value) for name, value in task.counters.items()}
    except (TypeError, ValueError, AttributeError):
        raise ParameterError(
            f"got {one_line(task.counters)}",
            expected="name -> number",
            hint="give each number of an array a name of its own",
            at="counters",
            source=f"task {task.name!r}",
        ) from None


def refuse_taken_names(task: Task, names: Iterable[str], taken: Iterable[str]) -> None:
    """Refuse counters that two entries of ``info`` would share.

    Raises:
        ParameterError: a counter has the name of another counter, or one of `taken`, or is called "step_error".
    """
    known = {*taken, "step_error"}
    for name in names:
        if name in known:
            raise ParameterError(
                f"got {name!r}, which info already has",
                hint="give the counter another name",
                at="counters",
                source=f"task {task.name!r}",
            )
        known.add(name)


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
