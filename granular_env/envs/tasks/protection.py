"""Protection-v0: hand a wall its impulse in time, and gently. Force-v0 is its older name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from ...components.chain import Chain
from ...components.chain.objective import Objective
from ...components.chain.readings import right_wall_force
from ...components.chain.table import GRAINS, REST, SCALARS, STIFFNESS, U
from ...components.jit import inlined, jit
from ...components.profiles import positive_number
from ..chain_environment import ChainEnv, ChainOptions
from ..chain_task import ChainTask, Policy
from .baselines import open_loops
from .making import chosen, driven_chain, hertz_chain, timed

FloatArray = npt.NDArray[np.float64]

# Layout of the constants: impulse to deliver [N s], peak force that costs 1 [N], length of a control step [s].
_IMPULSE, _PEAK_SCALE, _DURATION = range(3)
# Layout of the counters.
_DELIVERED, _FORCE, _PEAK = range(3)

# The smooth maximum is a p-norm, p = 2^_DOUBLINGS; the smooth positive part is rounded over this part of the impulse.
_DOUBLINGS = 5
_ROUNDING = 0.01


@jit
def _begin(a, counters, constants):
    counters[_FORCE] = counters[_PEAK] = right_wall_force(a)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    impulse, force = constants[_IMPULSE], right_wall_force(a)
    delivered = counters[_DELIVERED] + 0.5 * duration * (counters[_FORCE] + force)
    peak = max(counters[_PEAK], force)
    gain = min(delivered / impulse, 1.0) - min(counters[_DELIVERED] / impulse, 1.0)
    reward = gain - (peak - counters[_PEAK]) / constants[_PEAK_SCALE]
    counters[_DELIVERED], counters[_FORCE], counters[_PEAK] = delivered, force, peak
    return reward, delivered >= impulse


# -- the smooth counterpart -------------------------------------------------------------------------------------------


@jit
def _power(x):
    """x^p."""
    for _ in range(_DOUBLINGS):
        x *= x
    return x


@inlined
def _elastic_force(a):
    """Elastic force at the wall [N], and its derivative with respect to the overlap [N/m]."""
    n = int(a[SCALARS, GRAINS])
    d = max(a[U, n] - a[U, n + 1] + a[REST, n], 0.0)
    return a[STIFFNESS, n] * d * math.sqrt(d), 1.5 * a[STIFFNESS, n] * math.sqrt(d)


@jit
def _note(a, step, steps, inputs, constants, sums):
    force, _ = _elastic_force(a)
    # The trapezoid rule's last value counts half.
    part = 0.5 if step == steps - 1 else 1.0
    sums[0] += part * constants[_DURATION] * force / constants[_IMPULSE]
    sums[1] += _power(force / constants[_PEAK_SCALE])


@jit
def _value(sums, constants, slopes):
    missing = 1.0 - sums[0]
    root = math.sqrt(missing * missing + _ROUNDING * _ROUNDING)
    slopes[0] = -0.5 * (1.0 + missing / root)
    peak = sums[1]
    for _ in range(_DOUBLINGS):
        peak = math.sqrt(peak)
    slopes[1] = peak / (2.0**_DOUBLINGS * sums[1]) if sums[1] > 0.0 else 0.0
    return 0.5 * (missing + root) + peak


@jit
def _pull(a, bar, step, steps, inputs, input_bar, constants, slopes):
    n, (force, tangent) = int(a[SCALARS, GRAINS]), _elastic_force(a)
    if force <= 0.0:
        return
    part, ratio = 0.5 if step == steps - 1 else 1.0, force / constants[_PEAK_SCALE]
    slope = slopes[0] * part * constants[_DURATION] / constants[_IMPULSE]
    slope += slopes[1] * 2.0**_DOUBLINGS * _power(ratio) / force
    bar[U, n] += slope * tangent
    bar[U, n + 1] -= slope * tangent
    bar[REST, n] += slope * tangent
    bar[STIFFNESS, n] += slope * force / a[STIFFNESS, n]


# -- task and environment ---------------------------------------------------------------------------------------------


class ProtectionTask(ChainTask):
    """A wall shall receive an impulse; its peak force costs. See `ProtectionEnv`.

    Args:
        chain: what is driven, a wall at its right end.
        impulse: what the wall shall receive [N s].
        peak_scale: peak force of the wall that costs 1 [N].
        duration: of a control step [s].
        steps: control steps until the deadline, 0 for none.
        actions: input -> its value at action 1.
        observations: output -> its value observed as 1.
        arguments: of the environment, those that are not its defaults; they tell whether a best drive is known.
    """

    name = "protection"
    counter_names = ("delivered_impulse", "wall_force", "peak_wall_force")
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(
        self,
        chain: Chain,
        impulse: float,
        peak_scale: float,
        duration: float,
        steps: int,
        actions: Mapping[str, float],
        observations: Mapping[str, float],
        arguments: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__()
        self.actions, self.observations, self.arguments = actions, observations, arguments or {}
        self.observed_force = actions.get("left_force", self.observed_force)
        self.chain, self.duration, self.steps = chain, duration, steps
        self.impulse = positive_number("impulse", impulse)
        self.constants = np.array([self.impulse, positive_number("peak_scale", peak_scale), duration])

    def objective(self, chain: Chain, steps: int) -> Objective:
        """h(1 - delivered / impulse) + smooth peak / peak_scale, over all `steps`: delivery ends no episode here.

        h(x) = (x + sqrt(x^2 + .01^2)) / 2 is the positive part, rounded. The smooth peak is the p-norm of the wall's force over
        the control steps, (sum_t F_t^32)^(1/32), up to 1.2 times the peak. Both count the elastic part of the force.

        Raises:
            ParameterError: the contacts are not Hertz's.
        """
        hertz_chain(self.name, chain)
        text = "undelivered part of the wall's impulse, its positive part rounded, and the 32-norm of its force / peak_scale"
        return Objective(_note, _value, _pull, self.constants, count=2, description=text)
