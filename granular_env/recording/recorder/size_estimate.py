"""The size that a log may reach, before it is written."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.support.serialization import canonical_json
from ..format.header import component_facts
from ..preview.frame_selection import PreviewFrames, facts_of
from ..preview.messages import MOST_PICTURES, PreviewFrame, preview_messages
from .arguments import make_schedule, names_to_record
from .sampling import Schedule

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
        + _preview_bytes(component, frames)
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


def _preview_bytes(component: Component, frames: int) -> int:
    """Return the size of what stock viewers draw: all of it is made of two frames, and what a further one adds is counted."""
    track = PreviewFrames(facts_of(component))
    stride = 1
    while -(-frames // stride) > track.capacity:
        stride *= 2
    kept = -(-frames // stride)
    track.take(0, 0, component, component.balance_values())
    # What is zero takes less, and scalars that stay zero nothing; which these are is not known yet.
    drawn = {name: values if values.any() else values + np.float32(1e-9) for name, values in track.frames[0].drawn.items()}
    first = dataclasses.replace(track.frames[0], scalars=[1.0] * len(track.names), drawn=drawn)
    bare = dataclasses.replace(track.facts, drawables=())
    once = _size(track.facts, first, 1)
    pictured, plain = _size(track.facts, first, 2) - once, _size(bare, first, 2) - _size(bare, first, 1)
    pictures = min(kept, MOST_PICTURES)
    return once + (pictures - 1) * pictured + (kept - pictures) * plain


def _size(facts: Any, frame: PreviewFrame, count: int) -> int:
    frames = [dataclasses.replace(frame, number=number, nanoseconds=number * 1_000_000) for number in range(count)]
    return sum(sum(map(len, message.parts)) for message in preview_messages(facts, frames))
