"""The preview of a log for stock viewers, made again: from the frames of a damaged log, or from a re-run to be compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...components.component import Component
from ..container.reader import RawMessage
from ..format.metadata import title_of
from ..format.record_index import CHUNK, COUNT, KIND, LAST, SEGMENT
from ..format.records import HEADER, TOPICS, damage
from ..preview.frame_selection import FROM_FRAMES, PreviewFrames, facts_of, preview_facts
from ..preview.messages import PreviewFacts, PreviewMessage
from .log import Log

_PICTURES = 400


class PreviewBuilder:
    """Makes the preview of a log again, from what a re-run shows at each frame.

    Attributes:
        missing: why there is none to compare; "" where there is.
    """

    def __init__(self, log: Log, component: Component) -> None:
        """Read from the log's end how the preview was thinned."""
        self._log, self._number = log, 0
        facts = log.records.closing_header.get("preview")
        stride = facts.get("stride") if isinstance(facts, dict) else None
        self._stride = stride if type(stride) is int and 1 <= stride < 2**53 else 0
        self._from_frames = isinstance(facts, dict) and facts.items() >= FROM_FRAMES.items()
        self._preview: PreviewFrames | None = None
        self.missing = "" if log.records.closing is not None else "the preview"
        if self._stride and not self._from_frames:
            self._preview = PreviewFrames(facts_of(component, title_of(log.records.header)), self._stride)
        elif not self._from_frames and not self.missing:
            raise damage("its end does not say how its preview was made", "incidents", log.path)

    def take(self, component: Component, balances: Mapping[str, Any], tick: int) -> None:
        """Show it a frame of the re-run, at a tick of the log's time."""
        if self._preview is not None and self._preview.wants(self._number):
            self._preview.take(self._number, self._log.records.nanoseconds(tick), component, balances)
        self._number += 1

    def difference(self) -> str:
        """Return where the log's preview is not this one, in words; "" where it is the same, byte for byte.

        Raises:
            LogError: the file holds records that its index does not name, or at other times.
        """
        preview = self._preview_of_frames() if self._from_frames else self._preview
        messages = _preview_messages(self._log)
        try:
            for mine in preview.messages() if preview is not None else ():
                _compare(mine, next(messages, None))
            left = next(messages, None)
        except _PreviewDiffers as found:
            return str(found)
        return "" if left is None else f"a message under {left.topic!r} too many at {left.nanoseconds} ns"

    def _preview_of_frames(self) -> PreviewFrames | None:
        if not self._stride:
            return preview_of_frames(self._log)
        return preview_of_every(self._log, len(self._log.ticks(next(iter(self._log.variables)))), self._stride)


class _PreviewDiffers(Exception):  # noqa: N818 - a finding
    pass


def _compare(mine: PreviewMessage, other: RawMessage | None) -> None:
    what = f"the message under {mine.topic.name!r} at {mine.log_time} ns"
    if other is None:
        raise _PreviewDiffers(f"{what} is missing")
    if (other.topic, other.nanoseconds, other.published) != (mine.topic.name, mine.log_time, mine.publish_time):
        raise _PreviewDiffers(f"{other.topic!r} at {other.nanoseconds} ns stands in the place of {what}")
    if other.data != b"".join(mine.parts):
        raise _PreviewDiffers(f"{what} is not what the re-run gives")


def preview_of_frames(log: Log) -> PreviewFrames | None:
    """Return a preview of the frames that a log holds; None where they do not suffice for one."""
    facts = _facts_of_frames(log)
    units, wanted = facts.units, list(dict.fromkeys([*facts.units, *facts.sizes]))
    if not wanted or not log.segments:
        return None
    preview = PreviewFrames(facts)
    ticks = _common_ticks(log, wanted)
    for number, tick in enumerate(ticks[:: max(1, -(-len(ticks) // _PICTURES))].tolist()):
        time = tick * log.step_size
        values = [log.get(name, time) for name in units]
        preview.add(number, log.records.nanoseconds(tick), values, {name: log.get(name, time) for name in facts.sizes})
    return preview


def preview_of_every(log: Log, count: int, stride: int = 1) -> PreviewFrames:
    """Return the preview of the first frames that a log of one segment holds.

    Args:
        log: all of its variables have the same frames, as far as these.
        count: how many frames.
        stride: every so many of them are shown; twice, four times, ... as many where they would not fit.
    """
    facts = _facts_of_frames(log)
    capacity = PreviewFrames(facts).capacity
    while -(-count // stride) > capacity:
        stride *= 2
    preview, numbers = PreviewFrames(facts, stride), range(0, count, stride)
    names = list(dict.fromkeys([*facts.units, *facts.sizes]))
    shown = zip(*(_frames_at(log, name, numbers) for name in names), strict=True)
    for number, frames in zip(numbers, shown, strict=True):
        values = {name: value for name, (_, value) in zip(names, frames, strict=True)}
        scalars = [float(values[name]) for name in facts.units]
        preview.add(number, log.records.nanoseconds(frames[0][0]), scalars, {name: values[name] for name in facts.sizes})
    return preview


def _frames_at(log: Log, name: str, numbers: range) -> Iterator[tuple[int, np.ndarray]]:
    """Yield tick and value of the frames of these numbers."""
    first, records = 0, log.records
    for row in records.frame_rows(name):
        last = first + int(row[COUNT])
        chosen = [number for number in range(first + -first % numbers.step, last, numbers.step) if number in numbers]
        if chosen:
            ticks, values = records.frames(row, name)
            ticks = records.log_tick(row[SEGMENT], ticks)
            yield from ((int(ticks[number - first]), values[number - first]) for number in chosen)
        first = last


def _facts_of_frames(log: Log) -> PreviewFacts:
    units = {name: variable.unit for name, variable in log.variables.items() if variable.shape == ()}
    return preview_facts(title_of(log.records.header), log.drawables, log.variables, units)


def _common_ticks(log: Log, names: list[str]) -> np.ndarray:
    common = log.ticks(names[0])
    for name in names[1:]:
        common = np.intersect1d(common, log.ticks(name))
    return np.unique(common)


def _preview_messages(log: Log) -> Iterator[RawMessage]:
    """Yield the messages that are not of the exact content, in order; check that the others are those of the index."""
    rows, place, times = log.records.index.rows, 0, _times(log)
    for chunk, message in log.records.container.all_messages():
        kind = TOPICS.get(message.topic)
        if kind is None:
            yield message
            continue
        if place == len(rows) or (rows[place, CHUNK], rows[place, KIND]) != (chunk, kind):
            raise damage("it does not name each record", "index", log.path)
        if message.nanoseconds != times[place]:
            raise _PreviewDiffers(f"the time of the record {place} is {message.nanoseconds} ns, expected {times[place]} ns")
        place += 1
    if place != len(rows):
        raise damage("records that it names are missing", "index", log.path)


def _times(log: Log) -> list[int]:
    """Return the time of each record [ns]: that of its last tick, but never before that of the record before it."""
    times, latest, records = [], 0, log.records
    for kind, segment, last in records.index.rows[:, [KIND, SEGMENT, LAST]].tolist():
        if kind != HEADER and records.index.all_segments:
            latest = max(latest, records.nanoseconds(records.log_tick(segment, last)))
        times.append(latest)
    return times
