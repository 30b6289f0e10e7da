"""The size that a log may reach, before it is written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..components.component import Component
from .arguments import make_schedule, names_to_record

# What a frame takes beside its numbers, and a log beside its records [bytes].
_FRAME_BYTES, _LOG_BYTES = 100, 20_000


def estimated_bytes(
    component: Component,
    ticks: int,
    *,
    every: float | None = None,
    variables: Sequence[str] | None = None,
    hash_every: int | None = None,
    key_every: float | None = None,
    experiment: Any = None,
) -> int:
    """Return how many bytes a recording of so many ticks takes at most, before compression; arguments as for `record`."""
    names = names_to_record(component, variables)
    schedule = make_schedule(component, every, hash_every, key_every, experiment, names)
    numbers = sum(math.prod(component.variables[name].shape) for name in names)
    if schedule.frame_every:
        frames = ticks // schedule.frame_every + 1
    else:
        frames = schedule.doubling * (1 + max(0, ticks // schedule.doubling).bit_length())
    key_snapshots = ticks // schedule.key_every if schedule.key_every else 16 * ticks.bit_length()
    snapshots = 2 + min(key_snapshots, ticks // 4096 if not schedule.key_every else key_snapshots)
    hashed = sum(variable.state or variable.causality == "input" for variable in component.variables.values()) + 2
    return (
        frames * (8 * numbers + _FRAME_BYTES)
        + snapshots * component.state_bytes
        + ticks // schedule.hash_every * 8 * hashed
        + _LOG_BYTES
    )
