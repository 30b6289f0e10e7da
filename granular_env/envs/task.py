"""Tasks: the actions of an agent, its observations and its rewards.

A task knows a component by its contract, and knows nothing of Gymnasium. Tasks live one a file in ``tasks/``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from ..components.component import Component
from ..components.errors import ParameterError, one_line
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import positive_number
from ..components.variables import Element, parse_element
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
        unit_scales: unit -> value that is observed as 1, for further outputs that an environment's `observe` may choose.
        observation_limit: observations are clipped to +- this.
        lowest_action: actions are clipped to this and 1; the action space reaches from -1 to 1 all the same.
        counters: what the task remembers of the episode, name -> number; empty before `begin`. The environment saves and
            restores them, and shows them in ``info``. Anything else that a task remembers is lost by `restore`; `check_task`
            finds it.
        hold: control steps for which an action is held; set by the environment.
    """

    name: ClassVar[str]
    actions: Mapping[str, float]
    observations: Mapping[str, float]
    unit_scales: Mapping[str, float] = MappingProxyType({})
    observation_limit: float = 10.0
    lowest_action: float = -1.0
    counters: dict[str, Any]
    hold: int = 1

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Return start values for `Component.reset`; the default is the component's own start."""
        return {}

    def inputs(self, component: Component, driven: dict[str, Any]) -> dict[str, Any]:
        """Return the inputs of a control step, from those that the action drives; the default is these."""
        return driven

    @abstractmethod
    def begin(self, component: Component, seen: Seen) -> None:
        """Set the counters at the start of an episode."""

    @abstractmethod
    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Return the reward of a control step that lasted `duration` [s], and whether the episode has reached its end."""

    def objective(self, component: Any, steps: int) -> Any:
        """Return the smooth counterpart of minus the return over `steps` control steps, for gradients.

        A task may have keyword arguments of its own behind these two, with defaults: a study gives them in stages. One that
        draws goals has `goal`, and is given that of the episode.

        Raises:
            ParameterError: this task has none.
        """
        raise no_objective(self)

    def wanted(self, elapsed: int) -> FloatArray | None:
        """Return the wanted value of each particle's coloured quantity after `elapsed` control steps, for pictures, or None."""
        return None

    def baselines(self) -> Mapping[str, Policy]:
        """Return policies to compare with, by name: "nothing", "theory" (made by hand), "best" (best known); here none."""
        return {}


class RowTask(Task):
    """Base of tasks that judge many episodes at once: a native batch runs them, with the bits of single environments.

    Each argument of `begin_rows` and `judge_rows` has one row for each episode: `rows` are the components, as their domain's
    native batch shows them (for chains `domains.chain.rows.ChainRows`); `constants` are the task's, each field with a leading
    axis; `counters` are arrays of shape (episodes,), by name, to be written in place; `elapsed` are control steps done.

    Attributes:
        counter_names: what the counters hold, in order; each is shown in ``info``.
        constants: numbers and one-dimensional arrays that depend on the component, by name.
        goal_scales: of a goal that is drawn for each episode: what of each of its numbers is observed as 1. The goal is in the
            first counters.
    """

    counter_names: tuple[str, ...] = ()
    constants: NamedTuple | None = None
    goal_scales: tuple[float, ...] = ()

    @abstractmethod
    def begin_rows(self, rows: Any, constants: Any, counters: Mapping[str, FloatArray]) -> None:
        """Set the counters at the start of episodes; they are 0 before, but for a goal."""

    @abstractmethod
    def judge_rows(
        self, rows: Any, constants: Any, counters: Mapping[str, FloatArray], elapsed: npt.NDArray[np.int64]
    ) -> tuple[FloatArray, Any]:
        """Return the rewards of a control step, and which episodes have reached their end: an array, or False for none."""

    def goal(self, random: Generator) -> FloatArray:
        """Return the goal of an episode, as many numbers as `goal_scales`; drawn after `start`."""
        return np.zeros(0)

    def given_goal(self, given: Any) -> FloatArray:
        """Return the goal that `reset(options={"goal": ...})` asks for, in the form of `goal`.

        Raises:
            ParameterError: it is no goal, or this task has none.
        """
        raise ParameterError(f"task {self.name!r} draws no goal, and takes none", at="options.goal")

    def begin(self, component: Component, seen: Seen) -> None:
        """Do nothing: environments call `begin_rows`."""

    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Refuse: environments call `judge_rows`."""
        raise ParameterError(f"task {self.name!r} judges rows", hint="call judge_rows", at="judge")


def stack_constants(constants: list[Any]) -> Any:
    """Return constants of several tasks as one tuple, each field with a leading axis; shorter arrays are padded with 0."""
    if constants[0] is None:
        return None
    columns = [
        [np.atleast_1d(np.asarray(value, dtype=np.float64)) for value in column] for column in zip(*constants, strict=True)
    ]
    widths = [max(map(len, column)) for column in columns]
    padded = [
        np.array([np.pad(row, (0, width - len(row))) for row in column]) for column, width in zip(columns, widths, strict=True)
    ]
    scalars = [np.ndim(value) == 0 for value in constants[0]]
    return type(constants[0])(*(one[:, 0].copy() if flat else one for one, flat in zip(padded, scalars, strict=True)))


def element_scales(what: str, scales: Mapping[str, float], component: Component, causality: str) -> list[tuple[Element, float]]:
    """Return a task's actions or observations with their scales; `ParameterError` where the component has none such."""
    checked = []
    for name, scale in scales.items():
        try:
            element = parse_element(name)
            element.find(component.variables, f"an {causality} of component {component.name!r}", causality)
        except ParameterError as error:
            raise error.within(what, str(name)) from None
        checked.append((element, positive_number((what, name), scale)))
    if not checked:
        raise ParameterError("the task names none", expected=f"at least one {causality}", at=what)
    return checked


def no_objective(task: Task) -> ParameterError:
    """Return the error for a task without gradients."""
    return ParameterError(
        f"task {task.name!r} has no objective with a gradient",
        hint=f"use a method that needs none; components with gradients: {gradient_domains()}",
    )


def judgement(task: Task, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
    """Return the reward of a control step, and whether the task has ended.

    Raises:
        ParameterError: `judge` did not return (reward, done), the reward is not finite, or it stepped the component.
    """
    tick = component.tick
    given = task.judge(component, seen, duration)
    try:
        reward, done = given
        number = float(reward)
    except (TypeError, ValueError):
        raise ParameterError(f"task {task.name!r}: judge gave {one_line(given)}", expected="(reward, done)") from None
    refuse_infinite(task, number)
    if component.tick != tick:
        raise ParameterError(
            f"task {task.name!r}: its judge moved the component from tick {tick} to {component.tick}",
            hint="read the component with get(); ComponentEnv steps it",
        )
    return number, bool(done)


def refuse_infinite(task: Task, reward: float) -> None:
    """Raise `ParameterError` for a reward that is not a finite number."""
    if not math.isfinite(reward):
        raise ParameterError(f"task {task.name!r}: its reward is {reward}", hint="mend its judge")


def refuse_incomplete(task: Any) -> None:
    """Raise `ParameterError` for what is no task, or lacks an attribute that every task has."""
    if not isinstance(task, Task):
        raise ParameterError(f"got {one_line(task)}", expected="an object of a class made from Task", at="task")
    for name, example in (("name", '"swing"'), ("actions", '{"left_force": 100.0}'), ("observations", '{"velocity": 1.0}')):
        if not isinstance(getattr(task, name, None), str if name == "name" else Mapping):
            came = f"{type(task).__name__} has {one_line(getattr(task, name, None))}"
            raise ParameterError(came, expected=f"such as {name} = {example}", at=f"task.{name}")
