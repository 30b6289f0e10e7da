"""Signals of the held inputs: their means over each tick."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..inputs import Held
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray


def tick_signals(held: Mapping[str, Held], moved: Mapping[str, int], tick: int, ticks: int) -> FloatArray:
    """Return the mean factor of the pressure and the mean velocities of moved edges over each of `ticks` ticks from `tick` on.

    Returns:
        Shape (ticks, 1 + 3 edges).
    """
    signals = np.ones((ticks, 1 + 3 * len(moved)))
    if isinstance(held["pressure"], CompiledProfile):
        signals[:, 0] = held["pressure"].mean_factors(tick, ticks)
    for place, (edge, axis) in enumerate(moved.items()):
        velocity = held[f"{edge}_velocity"]
        columns = slice(1 + 3 * place, 4 + 3 * place) if axis < 0 else slice(1 + 3 * place + axis, 2 + 3 * place + axis)
        signals[:, columns] = pattern_of(velocity)
        if isinstance(velocity, CompiledProfile):
            signals[:, columns] *= velocity.mean_factors(tick, ticks)[:, None]
    return signals


def pattern_of(held: Held) -> FloatArray:
    """Return a copy of what the signal of an array input is multiplied by.

    Held arrays are read-only and those of some profiles are not: kernels would be compiled for both.
    """
    pattern = held.pattern if isinstance(held, CompiledProfile) else held
    return np.array(1.0 if pattern is None else pattern, dtype=np.float64)
