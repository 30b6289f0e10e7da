"""The actuator: converts an agent's action to inputs of a component, with clipping, rate limit, delay and scaling.

Commands are clipped, rate-limited actions. Arrays may have a leading axis with one row per environment of a batch.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..components.component import Component
from ..components.errors import ParameterError
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import finite_number, whole_number
from ..components.variables import Element
from .task import Task, element_scales

_LONGEST_DELAY = 100_000


class Actuator:
    """The conversion of actions to inputs. Its memory, an array, holds the commands of the last 1 + `control_delay` steps.

    Args:
        task: defines the driven inputs and their scales.
        component: component with these inputs.
        action_rate: largest change of an entry of the action in a control step; None for no limit.
        control_delay: number of control steps between an action and its effect.

    Attributes:
        driven: for each driven input or input element: its entries in the action, and the shape of the whole input.
        size: number of entries of the action.
        scales: input value at action 1, for each entry of the action.
        rate: largest change of an entry in a control step, in units of its scale; infinite for no limit.
        delay: number of control steps between an action and its effect.
        memory_size: size of the memory: 1 + delay commands, from the newest to the command that acts now.

    Raises:
        ParameterError: the component lacks an input, the rate is not above 0, or the delay is not a whole number >= 0.
    """

    def __init__(self, task: Task, component: Component, action_rate: float | None = None, control_delay: int = 0) -> None:
        self.driven: list[tuple[Element, slice, tuple[int, ...]]] = []
        scales: list[float] = []
        for element, scale in element_scales("actions", task.actions, component, "input"):
            shape, begin = component.variables[element.name].shape, len(scales)
            scales += [scale] * (1 if element.index else math.prod(shape))
            self.driven.append((element, slice(begin, len(scales)), shape))
        self.scales, self.size = np.array(scales), len(scales)
        self._low, self._high = np.full(self.size, task.lowest_action), np.ones(self.size)
        self.rate = math.inf if action_rate is None else finite_number("action_rate", action_rate)
        if self.rate <= 0.0:
            raise ParameterError(f"got {self.rate:g}", expected="more than 0, or None for no limit", at="action_rate")
        self.delay = whole_number("control_delay", control_delay, 0, _LONGEST_DELAY)
        self.memory_size = self.size * (1 + self.delay)
        # If all inputs are scalars, a faster conversion is used.
        self._names = None if any(shape for *_, shape in self.driven) else [element.name for element, *_ in self.driven]

    def initial_memory(self, component: Component) -> FloatArray:
        """Return the memory at the start of an episode, as if the component's present inputs had always been commanded."""
        held = [np.ravel(element.select_from(component.get(element.name))) for element, *_ in self.driven]
        return np.tile(np.concatenate(held) / self.scales, 1 + self.delay)

    def next_memory(self, actions: FloatArray, memory: FloatArray) -> FloatArray:
        """Return the memory after a further control step with the given actions, shape (..., entries)."""
        commands = np.minimum(np.maximum(actions, self._low), self._high)
        if self.rate < math.inf:
            newest = memory[..., : self.size]
            commands = np.minimum(np.maximum(commands, newest - self.rate), newest + self.rate)
        return np.concatenate([commands, memory[..., : -self.size]], axis=-1) if self.delay else commands

    def inputs(self, memory: FloatArray) -> dict[str, Any]:
        """Return the inputs, by name, that the oldest command in the memory gives; elements that are not driven are 0.

        Inputs are floats or arrays. If the memory has a leading axis, all inputs must be scalars and are arrays over this axis.
        """
        values = memory[..., -self.size :] * self.scales
        if self._names is not None:
            return dict(zip(self._names, values.tolist() if values.ndim == 1 else values.T, strict=True))
        inputs: dict[str, Any] = {}
        for element, part, shape in self.driven:
            name = element.name
            if element.index:
                inputs.setdefault(name, np.zeros(shape))[element.index] = values[part][0]
            else:
                inputs[name] = values[part].reshape(shape) if shape else float(values[part][0])
        return inputs
