"""Actuators, from an agent's action to the inputs of a chain: clipped, limited in rate, delayed, scaled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import finite_number

ACTUATE = "void(float64[::1], int64[::1], float64[::1], float64, int64, float64[::1], float64[::1])"
_LONGEST_DELAY = 100_000


@jit
def actuate(action, sides, scales, rate, delay, memory, inputs):
    """Write the inputs of this control step into `inputs` (left, right); other ends keep theirs.

    `memory` holds, for each entry of the action, the last command, then the `delay` commands that are on their way, the oldest
    first; in units of the scale.
    """
    count = len(sides)
    for i in range(count):
        command, last = action[i], memory[i]
        command = -1.0 if command < -1.0 else 1.0 if command > 1.0 else command
        if command - last > rate:
            command = last + rate
        elif last - command > rate:
            command = last - rate
        memory[i] = command
        if delay > 0:
            first = count + i * delay
            oldest = memory[first]
            for j in range(first, first + delay - 1):
                memory[j] = memory[j + 1]
            memory[first + delay - 1] = command
            command = oldest
        inputs[sides[i]] = scales[i] * command


@dataclass(frozen=True, eq=False)
class Actuator:
    """The effect of an action on the inputs.

    Attributes:
        names: the inputs that it drives, in the order of its entries.
        sides: 0 (left) or 1 (right), for each entry.
        scales: the input at action 1, for each entry [N or m/s].
        rate: largest change in a control step, in scales; infinite where there is no limit.
        delay: control steps between an action and its effect.
    """

    names: tuple[str, ...]
    sides: npt.NDArray[np.int64]
    scales: FloatArray
    rate: float
    delay: int

    @staticmethod
    def of(scales: Mapping[str, float], rate: Any = None, delay: Any = 0) -> Actuator:
        """Make it from the task's scales and an environment's `action_rate` and `control_delay`.

        Raises:
            ParameterError: the rate is not more than 0, or the delay is no whole number from 0.
        """
        limit = math.inf if rate is None else finite_number("action_rate", rate)
        if limit <= 0.0:
            raise ParameterError(f"got {limit:g}", expected="more than 0, or None for no limit", at="action_rate")
        if isinstance(delay, bool) or not isinstance(delay, (int, np.integer)) or not 0 <= delay <= _LONGEST_DELAY:
            raise ParameterError(
                f"got {one_line(delay)}", expected="a whole number of control steps from 0", at="control_delay"
            )
        sides = np.array([int(name.startswith("right")) for name in scales], dtype=np.int64)
        return Actuator(tuple(scales), sides, np.array(list(scales.values()), dtype=np.float64), limit, int(delay))

    @property
    def memory_size(self) -> int:
        """Numbers that it has to remember."""
        return len(self.names) * (1 + self.delay)

    def begin(self, memory: FloatArray, inputs: FloatArray) -> None:
        """Fill the memory as if the start's `inputs` had always been commanded."""
        count = len(self.names)
        memory[:count] = inputs[self.sides] / self.scales
        memory[count:] = np.repeat(memory[:count], self.delay)
