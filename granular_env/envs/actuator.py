"""Actuators: from an agent's action to the inputs of a component, clipped, limited in rate, delayed and scaled.

Commands are in units of the task's scales. Arrays may have a leading axis: one row for each environment of a batch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..components.component import Component
from ..components.errors import ParameterError
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import finite_number, whole_number
from ..components.variables import Element
from .task import Task, element_scales

_LONGEST_DELAY = 100_000


class Driven(NamedTuple):
    """An input, or an element of one, that an action drives.

    Attributes:
        element: of the input.
        scale: its value at action 1.
        part: its entries in the action.
        shape: of the whole input.
    """

    element: Element
    scale: float
    part: slice
    shape: tuple[int, ...]


class Actuator:
    """The effect of actions on inputs.

    Args:
        task: gives the driven inputs and their scales.
        component: has them.
        action_rate: largest change of an entry in a control step, in scales; None for no limit.
        control_delay: control steps between an action and its effect.

    Attributes:
        driven: what the action drives, in order.
        entries: what messages call each entry of the action.
        scales: the input at action 1, for each entry.
        rate: largest change in a control step, in scales; infinite where there is no limit.
        delay: control steps between an action and its effect.

    Raises:
        ParameterError: the component lacks an input, an element is driven twice, the rate is not above 0, or the delay is no
            whole number from 0.
    """

    def __init__(self, task: Task, component: Component, action_rate: float | None = None, control_delay: int = 0) -> None:
        self.driven: list[Driven] = []
        self.entries: list[str] = []
        for element, scale in element_scales("actions", task.actions, component, "input"):
            shape, begin = component.variables[element.name].shape, len(self.entries)
            names = [element] if element.index or not shape else [Element(element.name, index) for index in np.ndindex(shape)]
            self.entries += map(str, names)
            self.driven.append(Driven(element, scale, slice(begin, len(self.entries)), shape))
        _refuse_elements_driven_twice(self.driven)
        self.scales = np.repeat([one.scale for one in self.driven], [one.part.stop - one.part.start for one in self.driven])
        self.lowest = task.lowest_action
        self.rate = math.inf if action_rate is None else finite_number("action_rate", action_rate)
        if self.rate <= 0.0:
            raise ParameterError(f"got {self.rate:g}", expected="more than 0, or None for no limit", at="action_rate")
        self.delay = whole_number("control_delay", control_delay, 0, _LONGEST_DELAY)

    @property
    def memory_size(self) -> int:
        """Return how many numbers it remembers: the commands of each entry, the newest first, the one that acts last."""
        return len(self.entries) * (1 + self.delay)

    def line(self, memory: FloatArray) -> FloatArray:
        """Return its memory as commands, shape (..., entries, 1 + delay)."""
        return memory.reshape(*memory.shape[:-1], len(self.entries), 1 + self.delay)

    def begin(self, component: Component, memory: FloatArray) -> None:
        """Fill the memory as if the inputs that hold at the start had always been commanded."""
        line = self.line(memory)
        for one in self.driven:
            held = np.asarray(one.element.of(component.get(one.element.name)), dtype=np.float64)
            line[one.part] = (held / one.scale).reshape(-1, 1)

    def act(self, actions: FloatArray, memory: FloatArray) -> None:
        """Take actions, shape (..., entries), into the memory, shape (..., memory_size); the last commands are due then."""
        line = self.line(memory)
        commands = np.minimum(np.maximum(actions, self.lowest), 1.0)
        if self.rate < math.inf:
            newest = line[..., 0]
            commands = np.minimum(np.maximum(commands, newest - self.rate), newest + self.rate)
        if self.delay:
            line[..., 1:] = line[..., :-1].copy()
        line[..., 0] = commands

    def applied(self, memory: FloatArray) -> dict[str, Any]:
        """Return the inputs of the last commands, by the names of `driven`: numbers, or arrays with leading axes."""
        values, found = self.line(memory)[..., -1] * self.scales, {}
        for one in self.driven:
            value = values[..., one.part]
            is_whole = one.shape and not one.element.index
            shaped = value.reshape(*value.shape[:-1], *one.shape) if is_whole else value[..., 0]
            found[str(one.element)] = shaped if shaped.ndim else float(shaped)
        return found

    def inputs(self, applied: Mapping[str, Any]) -> dict[str, Any]:
        """Return whole inputs from what `applied` gave; elements that are not driven are 0."""
        inputs: dict[str, Any] = {}
        for one in self.driven:
            name, value = one.element.name, applied[str(one.element)]
            if one.element.index:
                inputs.setdefault(name, np.zeros(one.shape))[one.element.index] = value
            else:
                inputs[name] = value
        return inputs


def _refuse_elements_driven_twice(driven: list[Driven]) -> None:
    places = [one.element.counted_from_the_start(one.shape) for one in driven]
    for place, one in zip(places, driven, strict=True):
        if places.count(place) > 1 or (place.index and Element(place.name) in places):
            raise ParameterError(f"got {one.element} twice", expected="each element once", at="actions")
