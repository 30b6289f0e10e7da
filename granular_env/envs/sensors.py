"""The sensors: convert a component's outputs to an observation, optionally with noise, a goal and a clock.

Arrays have a leading axis with one row per environment; a single environment has one row.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from ..components.component import Component
from ..components.errors import ParameterError, one_line, spelling_hint
from ..components.support.counter_random import normal, stream_key
from ..components.support.float_arrays import FloatArray
from ..components.support.jit import JIT, jit
from ..components.support.validation import finite_number, whole_number
from .state import ELAPSED, SEED
from .task import RowTask, Task, element_scales

_LARGEST_CLOCK = 100
_EVERYTHING = "all"


class Sensors:
    """The conversion of outputs to observations, which consist of readings of outputs, then the goal, then the clock.

    Args:
        task: defines the outputs and their scales.
        component: component with these outputs.
        observe: "full" for the outputs of the task, or output -> indices along its first axis, or "all".
        noise: standard deviation of the noise on each reading, in units of its scale.
        clock: number of time readings, see `ComponentEnv`.
        deadline: number of control steps of an episode, for the clock; infinite for no end.

    Attributes:
        readings: for each output: its name, index of the observed elements (None for all), slice of the observation, scale.
        size: number of readings.
        goal: for each number of the goal: name of the task's counter that holds it -> value observed as 1.
        space: the observation space.

    Raises:
        ParameterError: an unknown output or index, an output without a scale, noise below 0, or a clock without a
            deadline.
    """

    def __init__(
        self, task: Task, component: Component, observe: Any, noise: float, clock: int, deadline: float
    ) -> None:  # fmt: skip
        self.limit, self.noise = task.observation_limit, finite_number("noise", noise)
        if self.noise < 0.0:
            raise ParameterError(f"got {self.noise:g}", expected="0 or more, in units of the observation's scales", at="noise")
        self.clock, self.deadline = whole_number("clock", clock, 0, _LARGEST_CLOCK), deadline
        if self.clock and math.isinf(deadline):
            hint = "give a deadline, or clock=0"
            raise ParameterError(f"got {clock}, but the environment has no deadline", hint=hint, at="clock")
        self.readings: list[tuple[str, Any, slice, float]] = []
        self.size = 0
        for name, index, scale in _observed_elements(observe, component, task):
            shape = component.variables[name].shape
            count = math.prod(np.empty(shape, np.bool_)[index].shape if index is not None else shape)
            self.readings.append((name, index, slice(self.size, self.size + count), scale))
            self.size += count
        self.goal = dict(zip(task.goal_names, task.goal_scales, strict=True)) if isinstance(task, RowTask) else {}
        high = np.full(self.size + len(self.goal), self.limit, np.float32)
        high = np.append(high, np.ones(self.clock, np.float32))
        self.space = gymnasium.spaces.Box(-high, high, dtype=np.float32)

    def make_observations(
        self, read: Callable[[str], Any], memories: FloatArray, goals: npt.ArrayLike
    ) -> npt.NDArray[np.float32]:
        """Return observations, one row per environment.

        Args:
            read: returns an output by name, with a leading axis.
            memories: memories of the environments (`EnvState.memory`).
            goals: goals in units of their scales, shape (environments, goal), or (goal,) for one environment.
        """
        seen = np.empty((len(memories), self.size + len(self.goal) + self.clock), np.float32)
        limit = math.inf if self.noise else self.limit  # with noise, clip only afterwards
        for name, index, place, scale in self.readings:
            value = read(name)
            chosen = value if index is None else value[:, *index]
            _scale_readings(chosen if chosen.ndim == 2 else chosen.reshape(len(seen), -1), 1.0 / scale, limit, seen[:, place])
        if self.noise:
            seeds, elapsed = memories[:, SEED].astype(np.int64), memories[:, ELAPSED].astype(np.int64)
            _blur(seen[:, : self.size], self.noise, self.limit, seeds, elapsed)
        if self.goal:
            seen[:, self.size : self.size + len(self.goal)] = np.clip(goals, -self.limit, self.limit)
        if self.clock:
            _write_clocks(memories[:, ELAPSED], self.deadline, seen[:, -self.clock :])
        return seen


def _observed_elements(observe: Any, component: Component, task: Task) -> Iterator[tuple[str, Any, float]]:
    """Yield for each observed output its name, the index of its observed elements, and the value observed as 1."""
    own = element_scales("observations", task.observations, component, "output")
    if isinstance(observe, str) and observe == "full":
        yield from ((element.name, element.index or None, scale) for element, scale in own)
        return
    if not isinstance(observe, Mapping) or not observe:
        raise ParameterError(f"got {one_line(observe)}", expected='"full", or output -> indices (at least one)', at="observe")
    # An output that the task does not name has the scale that the task gives for its unit.
    units = {component.variables[element.name].unit: scale for element, scale in own} | dict(task.unit_scales)
    outputs = [variable for variable in component.variables.values() if variable.causality == "output"]
    scales = {one.name: units[one.unit] for one in outputs if one.unit in units}
    scales |= {element.name: scale for element, scale in own}
    for name, places in observe.items():
        if name not in scales:
            hint = spelling_hint(str(name), scales)
            raise ParameterError(f"no output {one_line(name)} with a scale", hint=hint, at="observe")
        if isinstance(places, str) and places == _EVERYTHING:
            yield name, None, scales[name]
            continue
        shape, where = component.variables[name].shape, f"observe.{name}"
        if not shape:
            raise ParameterError(f"got {one_line(places)}", expected=f'"{_EVERYTHING}" as {name} is a number', at=where)
        listed = places if isinstance(places, Iterable) else [places]
        indices = [whole_number(where, place, -shape[0], shape[0] - 1) % shape[0] for place in listed]
        if not indices:
            raise ParameterError("no index", expected=f'indices, or "{_EVERYTHING}"', at=where)
        yield name, (indices,), scales[name]


@jit
def _scale_readings(values, factor, limit, out):
    for row in range(out.shape[0]):
        for i in range(out.shape[1]):
            x = values[row, i] * factor
            x = limit if x > limit else x
            out[row, i] = -limit if x < -limit else x


def _add_noise(readings, noise, limit, seeds, elapsed):
    """Add noise to the readings and clip them; the noise depends only on episode seed, control step and reading."""
    for k in range(readings.shape[0]):
        key = stream_key(seeds[k], elapsed[k])
        for i in range(readings.shape[1]):
            readings[k, i] = min(max(readings[k, i] + noise * normal(key, i), -limit), limit)


# With the JIT off, NumPy scalars would warn about the overflowing products of the noise.
_blur = jit(_add_noise) if JIT else np.errstate(over="ignore")(_add_noise)


@jit
def _write_clocks(elapsed, steps, out):
    """Write the time as cos(pi k elapsed / steps), k = 1, 2, ...: agents need it to know a deadline (Pardo et al. 2018)."""
    # cos((k + 1) x) = 2 cos(x) cos(k x) - cos((k - 1) x) needs only one cosine; accurate to 1e-14.
    for row in range(out.shape[0]):
        cosine = math.cos(math.pi * (elapsed[row] / steps))
        before, now = 1.0, cosine
        for k in range(out.shape[1]):
            out[row, k] = now
            before, now = now, 2.0 * cosine * now - before
