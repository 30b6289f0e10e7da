"""The items of a recorder's history: starts, steps and ends, each a single object that is added by one operation.

An interrupt (Ctrl-C, a signal's handler that raises) can fall between any two operations of the stepping thread.
What is noted is therefore whole or not there: all that follows from a step is in one object, and the last one tells where the
history stands.

Steps in which there was nothing to be seen follow one another in one list, as numbers and mappings of numbers: an object for
each would be one more for Python's collector of garbage to go through, again and again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...components.inputs import Held
from ...components.snapshot import Snapshot
from ..format.records import END
from .pending_data import RecordBatch, Samples


@dataclass(frozen=True, slots=True)
class Place:
    """A segment's place in the log.

    Attributes:
        segment: its number.
        start: its first tick.
        before: ticks of the whole log, and of its parents, before it.
    """

    segment: int
    start: int
    before: int

    def age(self, tick: int) -> int:
        """Return the ticks of the whole log, and of its parents, before a tick of this segment."""
        return self.before + tick - self.start


class Start(NamedTuple):
    """The start of a segment; see `Step`."""

    place: Place
    tick: int
    frames: int
    events: int
    samples: Samples


class Step(NamedTuple):
    """A step, or a part of one, in which there was something to be seen.

    Attributes:
        place: of its segment.
        tick: after it.
        frames: number of frames of the log after it.
        events: number of the component's events after it.
        inputs: that were set by it.
        samples: what was seen in it, if anything.
        rows: the events that happened in it, if there were any.
    """

    place: Place
    tick: int
    frames: int
    events: int
    inputs: Mapping[str, Held]
    samples: Samples | None
    rows: np.ndarray | None


class PlainSteps:
    """Steps in which there was nothing to be seen, one after the other.

    Attributes:
        place, frames, events: as of a `Step`.
        flat: the tick after each step and the inputs that were set by it, by turns. One call of `extend` adds both.
    """

    __slots__ = ("events", "flat", "frames", "place")

    def __init__(self, place: Place, frames: int, events: int, flat: list[Any]) -> None:
        self.place, self.frames, self.events, self.flat = place, frames, events, flat

    @property
    def tick(self) -> int:
        """Return the tick after the last of them."""
        return self.flat[-2]


class End(NamedTuple):
    """The end of a history; see `Step`. Once it has been written it has no snapshot any more."""

    place: Place
    tick: int
    frames: int
    events: int
    snapshot: Snapshot | None


Item = Start | Step | PlainSteps | End


def without_snapshot(item: Item) -> Item:
    """Return what stays of an item that has been written: where the history stands, without the copy of the state."""
    if isinstance(item, End):
        return item._replace(snapshot=None)
    return Step(item.place, item.tick, item.frames, item.events, {}, None, None)


def empty_batch(place: Place, tick: int) -> RecordBatch:
    """Return a batch of a segment with nothing in it, from a tick on."""
    return RecordBatch(place.segment, tick, place.before - place.start)


def batches_of(items: Iterable[Item], batch: RecordBatch) -> list[RecordBatch]:
    """Return the batches that a piece of history makes, the first of which goes on with `batch`; the last may be empty."""
    batches = [batch]
    for item in items:
        if isinstance(item, PlainSteps):
            batch.ends += item.flat[::2]
            batch.inputs += item.flat[1::2]
        elif isinstance(item, Step):
            batch.ends.append(item.tick)
            batch.inputs.append(item.inputs)
            if item.rows is not None:
                batch.events.append(item.rows)
            if item.samples is not None:
                batch.take(item.samples)
        elif isinstance(item, Start):
            batch = empty_batch(item.place, item.tick)
            batches.append(batch)
            batch.take(item.samples)
        elif item.snapshot is not None:
            batch.snapshots.append((item.tick, END, item.snapshot))
    return batches
