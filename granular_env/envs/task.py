"""Tasks: the actions of an agent, its observations and its rewards.

A task uses only the public methods of `Component`, not Gymnasium. The tasks of a domain are in its folder ``tasks/``.
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
"""Values of the observed outputs in SI units, by name."""


class Task:
    """Base of every task.

    Attributes:
        name: name of the task in messages and pictures.
        actions: input or input element (such as "force[3,0]") -> its value at action 1, in the unit of the input; action -1 is
            the opposite. The order is that of the action's entries.
        observations: output or output element -> its value observed as 1, in the unit of the output. The order is that of
            the observation's parts.
        unit_scales: unit -> value observed as 1, for outputs not in `observations` that the option `observe` selects.
        observation_limit: observations are clipped to +- this value.
        lowest_action: actions are clipped to the range from this value to 1; the action space is always -1 to 1.
        counters: state of the task in the episode, name -> number; empty before `begin_episode`. The environment saves and
            restores counters, and shows them in ``info``. `restore` loses any other state of a task.
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
        """Return start values for `Component.reset`; default: the component's default start."""
        return {}

    def inputs(self, component: Component, driven: dict[str, Any]) -> dict[str, Any]:
        """Return all inputs of a control step; `driven` are those set by the action, which are also the default."""
        return driven

    def begin_episode(self, component: Component, outputs: Seen) -> None:
        """Set the counters at the start of an episode; until then they are empty."""

    def evaluate_step(self, component: Component, outputs: Seen, duration: float) -> tuple[float, bool]:
        """Return the reward of a control step that lasted `duration` [s], and whether the episode has reached its end."""
        raise NotImplementedError(f"task {self.name!r} does not define evaluate_step")

    def objective(self, component: Any, steps: int) -> Any:
        """Return an objective for gradients: a differentiable replacement of minus the return over `steps` control steps.

        A task may have further keyword arguments with defaults, which a study sets in stages. A task that
        samples goals has the argument `goal` for the goal of the episode.

        Raises:
            ParameterError: the task has no objective.
        """
        raise ParameterError(
            f"task {self.name!r} has no objective with a gradient",
            hint=f"use a method without gradients; components with gradients: {gradient_domains()}",
        )

    def target_profile(self, elapsed: int) -> FloatArray | None:
        """Return the wanted values of the particles' coloured quantity after `elapsed` control steps, for pictures, or None."""
        return None

    def colours(self, component: Component) -> Mapping[str, FloatArray]:
        """Return values that colour drawables in pictures, by the drawable's name; 1 is red, -1 is blue.

        Default: none. Points and cells then have the output that they name, and links are not drawn.
        """
        return {}

    def baselines(self) -> Mapping[str, Policy]:
        """Return reference policies by name: "nothing", "theory" (from theory), "best" (best known); default: none."""
        return {}


class RowTask(Task):
    """Base of tasks that can judge many episodes at once, for native batches; results are bitwise those of single environments.

    `begin_rows` and `evaluate_rows` serve one episode, or several with arrays of one row per episode; NumPy expressions handle
    both cases. `rows` are the components as an object of the class `Domain.rows`, `constants` those of the task, `counters`
    the numbers that the methods replace, by name, and `elapsed` the number of control steps since the start.

    Attributes:
        counter_names: names of the counters in order; ``info`` shows all counters.
        constants: a `NamedTuple` of numbers and one-dimensional arrays that depend on the component; None for none.
        goal_scales: for each number of a goal that is sampled in each episode, its value that is observed as 1. The first
            counters hold the goal.
    """

    counter_names: tuple[str, ...] = ()
    constants: Any = None
    goal_scales: tuple[float, ...] = ()

    @property
    def goal_names(self) -> tuple[str, ...]:
        """Return the names of the counters that hold the goal."""
        return self.counter_names[: len(self.goal_scales)]

    def begin_rows(self, rows: Any, constants: Any, counters: dict[str, Any]) -> None:
        """Set the counters at the start of episodes; until then they are 0, except those of a goal."""

    def evaluate_rows(self, rows: Any, constants: Any, counters: dict[str, Any], elapsed: Any) -> tuple[Any, Any]:
        """Return the rewards of a control step, and a mask of the episodes that have reached their end (False for none)."""
        raise NotImplementedError(f"task {self.name!r} does not define evaluate_rows")

    def sample_goal(self, random: Generator) -> FloatArray:
        """Return the goal of an episode, one number per entry of `goal_scales`; sampled after `start`."""
        return np.zeros(0)

    def parse_goal(self, given: Any) -> FloatArray:
        """Return the goal given to `reset(options={"goal": ...})`, in the form of `sample_goal`.

        Raises:
            ParameterError: not a valid goal, or the task has no goal.
        """
        raise ParameterError(f"task {self.name!r} has no goal", at="options.goal")


def stack_constants(constants: list[Any]) -> Any:
    """Return the constants of several tasks as one tuple whose fields have a leading axis; shorter arrays are padded with 0."""
    if constants[0] is None:
        return None
    stacked = []
    for column in zip(*constants, strict=True):
        width = max(np.size(value) for value in column)
        padded = np.array([np.pad(np.ravel(value), (0, width - np.size(value))) for value in column], dtype=np.float64)
        stacked.append(padded if np.ndim(column[0]) else padded[:, 0].copy())
    return type(constants[0])(*stacked)


def element_scales(what: str, scales: Mapping[str, float], component: Component, causality: str) -> list[tuple[Element, float]]:
    """Return the elements named in a task's actions or observations, with scales; `ParameterError` if one is missing."""
    checked = []
    for name, scale in scales.items():
        try:
            element = parse_element(name)
            element.find_variable(component.variables, f"an {causality} of component {component.name!r}", causality)
        except ParameterError as error:
            raise error.with_outer_location(what, str(name)) from None
        checked.append((element, positive_number((what, name), scale)))
    return checked
