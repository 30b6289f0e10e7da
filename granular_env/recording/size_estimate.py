"""The size that a log may reach, before it is written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..components.component import Component
from ..components.support.serialization import canonical_json
from .header import component_facts
from .preview.film import Preview
from .schedule import Schedule, make_schedule, names_to_record

# What a record of a frame takes beside its numbers, and a log beside its records [bytes].
_FRAME_BYTES, _LOG_BYTES = 10, 20_000


def estimated_bytes(
    component: Component,
    ticks: int,
    *,
    every: float | None = None,
    variables: Sequence[str] | None = None,
    hash_every: int | None = None,
    snapshot_every: float | None = None,
    experiment: Any = None,
) -> int:
    """Return how many bytes a recording of so many ticks takes at most, before compression; arguments as for `record`.

    Where neither the state nor what is drawn of it grows or shrinks on the way, that is what it takes, within a few per cent.
    """
    names = names_to_record(component, variables)
    schedule = make_schedule(component, every, hash_every, snapshot_every, experiment, names)
    numbers = sum(math.prod(component.variables[name].shape) for name in names)
    frames = _frames(schedule, ticks)
    hashed = sum(variable.state or variable.causality == "input" for variable in component.variables.values()) + 2
    return (
        _LOG_BYTES
        + _header_bytes(component, names)
        + frames * (8 * numbers + _FRAME_BYTES * len(names))
        + (2 + _key_snapshots(schedule, ticks)) * component.state_bytes
        + ticks // schedule.hash_every * 8 * hashed
        + _preview_bytes(component, names, frames)
    )


def _frames(schedule: Schedule, ticks: int) -> int:
    if schedule.frame_every:
        return ticks // schedule.frame_every + 1
    return schedule.doubling * (1 + max(0, ticks // schedule.doubling).bit_length())


def _key_snapshots(schedule: Schedule, ticks: int) -> int:
    if schedule.snapshot_every:
        return ticks // schedule.snapshot_every
    count = tick = 0
    while (tick := schedule.key_after(tick, tick)) <= ticks:
        count += 1
    return count


def _header_bytes(component: Component, names: list[str]) -> int:
    facts, arrays = component_facts(component, names)
    return len(canonical_json(facts)) + sum(array.nbytes for array in arrays.values())


def _preview_bytes(component: Component, names: list[str], frames: int) -> int:
    """Return the size of what stock viewers draw: its messages of one frame, for each frame that it keeps."""
    preview = Preview(component.name, component.drawables(), {name: component.variables[name] for name in names})
    balances = component.balance_values()
    values = {name: balances[name] if name in balances else component.peek(name) for name in names}
    # A scalar that stays zero is left out; which these are is not known yet.
    preview.add(0, {name: value if np.ndim(value) else 1.0 for name, value in values.items()})
    sizes = [(message.topic.schema, len(message.data)) for message in preview.messages()]
    pictures, rows = _kept(frames, preview.capacity), _kept(frames, preview.most_frames)
    return sum(size * (pictures if schema == "foxglove.PointCloud" else rows) for schema, size in sizes)


def _kept(frames: int, most: int) -> int:
    stride = 1
    while -(-frames // stride) > most:
        stride *= 2
    return -(-frames // stride)
