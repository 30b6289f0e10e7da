"""The index of a log: one row of numbers per message, read from the log's last record or made by scanning the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .container import Container
from .records import (
    CLOSED,
    COLUMNS,
    EVENTS,
    FRAMES,
    HASHES,
    HEADER,
    INCIDENTS,
    KINDS,
    SNAPSHOTS,
    START,
    STEPS,
    Record,
    damage_error,
    decode_record,
    record_kind,
)  # fmt: skip

# Largest tick: beyond this, successive whole numbers are not distinguishable as float64.
_MOST_TICKS = 2**53
# Numbers of the columns of a row in the file, and of one more, which is computed: the message's position in its chunk.
KIND, DETAIL, SEGMENT, FIRST, LAST, COUNT, NUMBER, CHUNK, PLACE = range(len(COLUMNS) + 1)


@dataclass(frozen=True, slots=True)
class Segment:
    """A segment of a log: an uninterrupted history, which starts with a reset or a restore of the component.

    Attributes:
        number: position among the segments of the log, from 0.
        start, end: first and last tick, as counted by the component.
        elapsed: ticks of the log before the segment.
    """

    number: int
    start: int
    end: int
    elapsed: int


class Index:
    """The rows of all messages except those for stock viewers, in the order of writing, and the segments of the log."""

    def __init__(self, path: str, rows: np.ndarray) -> None:
        """Check that no row is missing, duplicated or out of order."""
        self.path = path
        self._check_order(rows)
        chunks = rows[:, CHUNK]
        self.rows = rows = np.column_stack([rows, np.arange(len(rows)) - np.searchsorted(chunks, chunks)])
        self._by_kind = [rows[rows[:, KIND] == kind] for kind in range(len(KINDS))]
        for name, own in zip(KINDS, self._by_kind, strict=True):
            if not np.array_equal(own[:, NUMBER], np.arange(len(own))) or (np.diff(own[:, SEGMENT]) < 0).any():
                raise damage_error("records are missing, duplicated or out of order", name, path)
        self.all_segments = self._find_segments()
        lived = [segment for segment in self.all_segments if segment.end > segment.start]
        self.segments = lived or self.all_segments[-1:]

    def select_rows(self, kind: int, detail: int | None = None, segment: int | None = None) -> np.ndarray:
        """Return the rows of one kind of record, optionally of one detail and one segment, in the order of writing."""
        rows = self._by_kind[kind]
        if segment is not None:
            # Rows are sorted by segment, so a binary search finds them without a pass over all rows.
            first, last = np.searchsorted(rows[:, SEGMENT], [segment, segment + 1])
            rows = rows[first:last]
        return rows if detail is None else rows[rows[:, DETAIL] == detail]

    def _check_order(self, rows: np.ndarray) -> None:
        kind, first, last, count = rows[:, [KIND, FIRST, LAST, COUNT]].T
        bad = (kind < 0) | (kind >= len(KINDS)) | (first < 0) | (first > last) | (last >= _MOST_TICKS)
        # No two frames, hashes or steps have the same tick, so a record cannot contain more of them than ticks.
        bad |= (count < 1) | ((count > last - first + 1) & (kind != EVENTS)) | (rows[:, CHUNK] < 0)
        bad |= (kind == HEADER) != (np.arange(len(rows)) == 0)
        is_long = count.sum(dtype=np.float64) >= _MOST_TICKS
        if bad.any() or is_long or not len(rows) or (np.diff(rows[:, CHUNK]) < 0).any():
            raise damage_error("the index does not describe a log", "index", self.path)

    def _find_segments(self) -> list[Segment]:
        starts = self.select_rows(SNAPSHOTS, START)
        if not np.array_equal(starts[:, SEGMENT], np.arange(len(starts))):
            raise damage_error("the snapshot at the start of a segment is missing or duplicated", "snapshots", self.path)
        segments, elapsed = [], 0
        for number, start in enumerate(starts[:, FIRST].tolist()):
            steps = self.select_rows(STEPS, None, number)
            marks = np.concatenate([[start], steps[:, LAST]])
            if not np.array_equal(steps[:, FIRST], marks[:-1]):
                raise damage_error(f"records of segment {number} are missing or not contiguous", "steps", self.path)
            segments.append(Segment(number, start, int(marks[-1]), elapsed))
            elapsed += int(marks[-1]) - start
        if elapsed >= _MOST_TICKS:
            raise damage_error("the index does not describe a log", "index", self.path)
        self._check_places(segments)
        return segments

    def _check_places(self, segments: list[Segment]) -> None:
        """Raise an error for a segment that has no start, and for a record whose ticks lie outside its segment."""
        numbers = self.rows[1:, SEGMENT]
        if (numbers < 0).any() or (numbers >= max(len(segments), 1)).any():
            raise damage_error("a record belongs to a segment without a start", "index", self.path)
        rows = self.rows[np.isin(self.rows[:, KIND], (FRAMES, HASHES, SNAPSHOTS, EVENTS))]
        if segments:
            begins, ends = np.array([(s.start, s.end) for s in segments])[rows[:, SEGMENT]].T
            if (rows[:, FIRST] < begins).any() or (rows[:, LAST] > ends).any():
                raise damage_error("a record has ticks outside its segment", "index", self.path)


def find_index(container: Container) -> tuple[Index, Record | None]:
    """Return the index, and the closing record if there is one.

    Raises:
        LogError: a complete file has no closing record, or the index is invalid.
    """
    path, closing = str(container.path), _closing_record(container)
    if container.complete and closing is None:
        raise damage_error("the file has a summary but no closing record", "incidents", path)
    if container.complete and closing is not None:
        rows = closing.arrays.get("index")
        if rows is None or rows.dtype != np.int64 or rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
            raise damage_error("the index has the wrong shape or dtype", "index", path)
        container.limits.check_records(len(rows), container.size)
        if len(rows) and rows[:, CHUNK].max() >= len(container.places):
            raise damage_error("the index refers to a chunk that does not exist", "index", path)
        return Index(path, np.vstack([rows, [*closing.row, len(container.places) - 1]])), closing
    rows = np.array([(*record.row, chunk) for chunk, _, record in all_records(container)], dtype=np.int64)
    return Index(path, _complete_rows(rows.reshape(-1, len(COLUMNS)), closing is not None)), closing


def _complete_rows(rows: np.ndarray, closed: bool) -> np.ndarray:
    """Return the rows up to the last step record, and a segment start just after it; a kill may cut off what follows."""
    if closed:
        return rows
    written = np.flatnonzero(rows[:, KIND] == STEPS)
    last = int(written[-1]) + 1 if len(written) else 1
    starts = (rows[last : last + 1, KIND] == SNAPSHOTS) & (rows[last : last + 1, DETAIL] == START)
    return rows[: last + int(starts.sum())]


def _closing_record(container: Container) -> Record | None:
    """Return the record in the last message if it is the one that closes a log; otherwise return None."""
    for topic, message in container.messages(len(container.places) - 1)[-1:]:
        if record_kind(topic) == INCIDENTS:
            record = decode_record(message.data, INCIDENTS, container.text_limit)
            return record if record.detail == CLOSED else None
    return None


def all_records(container: Container) -> Iterator[tuple[int, int, Record]]:
    """Yield (chunk number, message time [ns], record) of all messages except those for stock viewers, in order."""
    for chunk, (topic, message) in container.all_messages():
        if (kind := record_kind(topic)) is not None:
            yield chunk, message.log_time, decode_record(message.data, kind, container.text_limit)
