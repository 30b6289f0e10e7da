"""Means of the held inputs over each tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..inputs import Held
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray
from .kernel_arrays import AREA, LEFT_PRESSURE, LEFT_VELOCITY, POWER, RIGHT_PRESSURE, RIGHT_VELOCITY, SIGNALS

COLUMNS = {
    "ignition_power": POWER, "left_pressure": LEFT_PRESSURE, "right_pressure": RIGHT_PRESSURE, "left_velocity": LEFT_VELOCITY,
    "right_velocity": RIGHT_VELOCITY,
}  # fmt: skip


def tick_signals(held_inputs: Mapping[str, Held], tick: int, ticks: int) -> FloatArray:
    """Return the mean of each input over each of `ticks` ticks, starting at `tick`, shape (ticks, SIGNALS)."""
    signals = np.zeros((ticks, SIGNALS))
    for name, column in COLUMNS.items():
        signals[:, column] = _mean_factors(held_inputs.get(name, 0.0), tick, ticks)
    area = held_inputs.get("area")
    signals[:, AREA] = _mean_factors(area, tick, ticks) if isinstance(area, CompiledProfile) else 1.0
    return signals


def _mean_factors(held_input: Any, tick: int, ticks: int) -> FloatArray | float:
    return held_input.mean_factors(tick, ticks) if isinstance(held_input, CompiledProfile) else held_input


def area_pattern(held_inputs: Mapping[str, Held]) -> FloatArray:
    """Return a copy of the cross-sections that are multiplied by the signal of the input `area`, shape (n,) [m^2].

    The copy is always writable. Otherwise numba would compile twice, for read-only and for writable arrays.
    """
    area = held_inputs["area"]
    return np.array(area.pattern if isinstance(area, CompiledProfile) else area)
