"""The history that a recorder notes: starts, steps and ends, each one object that is added by one operation.

An interrupt (Ctrl-C, a signal's handler that raises) can fall between any two operations of the stepping thread.
What is noted is therefore whole or not there: all that follows from a step is in one object, and the last one tells where the
history stands.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from operator import sub
from typing import Any, NamedTuple

import numpy as np

from ...components.inputs import Held
from ...components.snapshot import Snapshot
from ..format.records import END
from .record_batch import RecordBatch, Samples


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
    """A step, or a part of one.

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


class End(NamedTuple):
    """The end of a history; see `Step`."""

    place: Place
    tick: int
    frames: int
    events: int
    snapshot: Snapshot


Item = Start | Step | End


def empty_batch(place: Place, tick: int) -> RecordBatch:
    """Return a batch of a segment with nothing in it, from a tick on."""
    return RecordBatch(place.segment, tick, place.before - place.start)


def batches_of(items: Iterable[Item], batch: RecordBatch) -> list[RecordBatch]:
    """Return the batches that a piece of history makes, the first of which goes on with `batch`; the last may be empty."""
    batches = [batch]
    for kind, run in groupby(items, type):
        if kind is Step:
            _add_steps(batch, list(run))
            continue
        for item in run:
            if isinstance(item, Start):
                batch = empty_batch(item.place, item.tick)
                batches.append(batch)
                batch.take(item.samples)
            elif isinstance(item, End):
                batch.snapshots.append((item.tick, END, item.snapshot))
    return batches


def _add_steps(batch: RecordBatch, steps: list[Any]) -> None:
    # As wholes: there may be hundreds of thousands a second, and the stepping thread waits for this one.
    ticks = [step[1] for step in steps]
    batch.sets += [(place, step[4]) for place, step in enumerate(steps, len(batch.durations)) if step[4]]
    batch.durations += map(sub, ticks, [batch.last, *ticks[:-1]])
    batch.last = ticks[-1]
    for step in [step for step in steps if step[5] is not None or step[6] is not None]:
        if step.rows is not None:
            batch.events.append(step.rows)
        if step.samples is not None:
            batch.take(step.samples)
