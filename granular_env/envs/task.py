"""Tasks: the actions of an agent, its observations and its rewards.

A task knows a component by its contract, and knows nothing of Gymnasium. Tasks live one a file in ``tasks/``.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from ..components.component import Component
from ..components.errors import ParameterError
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import positive_number
from ..components.variables import Element, parse_element
from ..domains import gradient_domains
from .policies import Policy

Seen = Mapping[str, npt.NDArray[np.float64]]
"""The observed outputs, unscaled, name -> value."""


class Task:
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
            restores them, and shows them in ``info``. Anything else that a task remembers is lost by `restore`.
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

    def begin(self, component: Component, seen: Seen) -> None:
        """Set the counters at the start of an episode; there are none before."""

    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Return the reward of a control step that lasted `duration` [s], and whether the episode has reached its end."""
        raise NotImplementedError(f"task {self.name!r} has no judge")

    def objective(self, component: Any, steps: int) -> Any:
        """Return the smooth counterpart of minus the return over `steps` control steps, for gradients.

        A task may have further keyword arguments with defaults: a study gives them in stages. One that
        draws goals has `goal`, and is given that of the episode.

        Raises:
            ParameterError: this task has none.
        """
        raise ParameterError(
            f"task {self.name!r} has no objective with a gradient",
            hint=f"use a method that needs none; components with gradients: {gradient_domains()}",
        )

    def wanted(self, elapsed: int) -> FloatArray | None:
        """Return the wanted value of each particle's coloured quantity after `elapsed` control steps, for pictures, or None."""
        return None

    def baselines(self) -> Mapping[str, Policy]:
        """Return policies to compare with, by name: "nothing", "theory" (made by hand), "best" (best known); here none."""
        return {}


class RowTask(Task):
    """Base of tasks that judge many episodes at once: a native batch runs them, with the bits of single environments.

    The arguments of `begin_rows` and `judge_rows` are those of one episode, or have one row for each of many: `rows` are the
    components, as their domain's native batch shows them (`Domain.rows`); `constants` are the task's; `counters` are numbers
    by name, to be replaced by new ones; `elapsed` are control steps done. Expressions of numpy serve both.

    Attributes:
        counter_names: what the counters hold, in order; each is shown in ``info``.
        constants: a `NamedTuple` of numbers and one-dimensional arrays that depend on the component; None for none.
        goal_scales: of a goal that is drawn for each episode: what of each of its numbers is observed as 1. The goal is in the
            first counters.
    """

    counter_names: tuple[str, ...] = ()
    constants: Any = None
    goal_scales: tuple[float, ...] = ()

    @property
    def goal_names(self) -> tuple[str, ...]:
        """Return the counters that hold the goal."""
        return self.counter_names[: len(self.goal_scales)]

    def begin_rows(self, rows: Any, constants: Any, counters: dict[str, Any]) -> None:
        """Set the counters at the start of episodes; they are 0 before, but for a goal."""

    def judge_rows(self, rows: Any, constants: Any, counters: dict[str, Any], elapsed: Any) -> tuple[Any, Any]:
        """Return the rewards of a control step, and which episodes have reached their end; False for none."""
        raise NotImplementedError(f"task {self.name!r} has no judge_rows")

    def goal(self, random: Generator) -> FloatArray:
        """Return the goal of an episode, as many numbers as `goal_scales`; drawn after `start`."""
        return np.zeros(0)

    def given_goal(self, given: Any) -> FloatArray:
        """Return the goal that `reset(options={"goal": ...})` asks for, in the form of `goal`.

        Raises:
            ParameterError: it is no goal, or this task has none.
        """
        raise ParameterError(f"task {self.name!r} draws no goal, and takes none", at="options.goal")


def stack_constants(constants: list[Any]) -> Any:
    """Return constants of several tasks as one tuple, each field with a leading axis; shorter arrays are padded with 0."""
    if constants[0] is None:
        return None
    stacked = []
    for column in zip(*constants, strict=True):
        width = max(np.size(value) for value in column)
        padded = np.array([np.pad(np.ravel(value), (0, width - np.size(value))) for value in column], dtype=np.float64)
        stacked.append(padded if np.ndim(column[0]) else padded[:, 0].copy())
    return type(constants[0])(*stacked)


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
    return checked
