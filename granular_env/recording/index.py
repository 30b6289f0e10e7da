"""The index of a log: one row a message; read from the closing record, or made by going through the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .container import Container, Entry
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
    damage,
    decode,
    kind_of,
)  # fmt: skip

# Whole numbers of ticks beyond this are not told apart by a time in float64.
_MOST_TICKS = 2**53
KIND, DETAIL, SEGMENT, FIRST, LAST, COUNT, NUMBER, CHUNK = range(len(COLUMNS))


@dataclass(frozen=True, slots=True)
class Segment:
    """An unbroken history, from a reset or a restore on.

    Attributes:
        number: place in the log.
        start, end: its first and last tick.
        elapsed: ticks of the log before it.
    """

    number: int
    start: int
    end: int
    elapsed: int


class Index:
    """Rows of all messages of the exact content, in the order they were written, and what follows from them."""

    def __init__(self, path: str, rows: np.ndarray) -> None:
        """Check that nothing is missing, doubled or out of order."""
        self.path, self.rows = path, rows
        self._check_order()
        self._by_kind = [rows[rows[:, KIND] == kind] for kind in range(len(KINDS))]
        self._check_numbers()
        self.all_segments = self._segments()
        lived = [segment for segment in self.all_segments if segment.end > segment.start]
        self.segments = lived or self.all_segments[-1:]

    def select(self, kind: int, detail: int | None = None, segment: int | None = None) -> np.ndarray:
        """Return the rows of one kind, in the order in which they were written."""
        rows = self._by_kind[kind]
        if segment is not None:
            # They are in the order of segments, so looking one up takes no pass over all of them.
            first, last = np.searchsorted(rows[:, SEGMENT], [segment, segment + 1])
            rows = rows[first:last]
        return rows if detail is None else rows[rows[:, DETAIL] == detail]

    def _check_order(self) -> None:
        rows = self.rows
        known = (rows[:, KIND] >= 0) & (rows[:, KIND] < len(KINDS))
        bad = ~known | (rows[:, FIRST] > rows[:, LAST]) | (rows[:, FIRST] < 0) | (rows[:, LAST] >= _MOST_TICKS)
        # A frame, a hash or a step stands at a tick of its own, so there are never more of them than ticks.
        crowded = (rows[:, COUNT] > rows[:, LAST] - rows[:, FIRST] + 1) & (rows[:, KIND] != EVENTS)
        bad |= (rows[:, COUNT] < 1) | crowded | (rows[:, CHUNK] < 0)
        if bad.any() or not len(rows) or rows[0, KIND] != HEADER or (rows[1:, KIND] == HEADER).any():
            raise damage("it does not describe a log", "index", self.path)
        if (np.diff(rows[:, CHUNK]) < 0).any() or rows[:, COUNT].sum(dtype=np.float64) >= _MOST_TICKS:
            raise damage("it does not describe a log", "index", self.path)

    def _check_numbers(self) -> None:
        for kind, rows in enumerate(self._by_kind):
            if not np.array_equal(rows[:, NUMBER], np.arange(len(rows))) or (np.diff(rows[:, SEGMENT]) < 0).any():
                raise damage("records are missing, doubled or out of order", KINDS[kind], self.path)

    def _segments(self) -> list[Segment]:
        starts = self.select(SNAPSHOTS, START)
        if not np.array_equal(starts[:, SEGMENT], np.arange(len(starts))):
            raise damage("that of the start of a segment is missing or doubled", "snapshots", self.path)
        if (self.rows[1:, SEGMENT] >= max(len(starts), 1)).any() or (self.rows[:, SEGMENT] < 0).any():
            raise damage("a record belongs to a segment that has no start", "index", self.path)
        steps = self.select(STEPS)
        bounds = np.searchsorted(steps[:, SEGMENT], np.arange(len(starts) + 1))
        segments, elapsed = [], 0
        for number, start in enumerate(starts[:, FIRST].tolist()):
            own = steps[bounds[number] : bounds[number + 1]]
            marks = np.concatenate([[start], own[:, LAST]])
            if not np.array_equal(own[:, FIRST], marks[:-1]):
                raise damage(f"those of segment {number} are missing or do not follow one another", "steps", self.path)
            segments.append(Segment(number, start, int(marks[-1]), elapsed))
            elapsed += int(marks[-1]) - start
        if elapsed >= _MOST_TICKS:
            raise damage("it does not describe a log", "index", self.path)
        self._check_ticks(segments)
        return segments

    def _check_ticks(self, segments: list[Segment]) -> None:
        if not segments:
            return
        begins, ends = np.array([s.start for s in segments]), np.array([s.end for s in segments])
        rows = self.rows[np.isin(self.rows[:, KIND], (FRAMES, HASHES, SNAPSHOTS, EVENTS))]
        if (rows[:, FIRST] < begins[rows[:, SEGMENT]]).any() or (rows[:, LAST] > ends[rows[:, SEGMENT]]).any():
            raise damage("a record is of ticks outside of its segment", "index", self.path)


def find_index(container: Container) -> tuple[Index, Record | None]:
    """Return the index, and the closing record if there is one.

    Raises:
        LogError: a complete file has no closing record, or an index describes no log.
    """
    path, most_text = str(container.path), container.most_text
    closing, entry = None, _last_entry(container)
    if entry is not None and kind_of(entry.topic) == INCIDENTS:
        record = decode(entry.message.data, INCIDENTS, most_text)
        closing = record if record.detail == CLOSED else None
    if container.complete and closing is None:
        raise damage("the file has an end, but no record says that it was closed", "incidents", path)
    if closing is not None and container.complete:
        rows = closing.arrays.get("index")
        if rows is None or rows.dtype != np.int64 or rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
            raise damage("it has the wrong form", "index", path)
        container.limits.check_records(len(rows), container.size)
        if len(rows) and rows[:, CHUNK].max() >= container.chunk_count:
            raise damage("it names a chunk that is not there", "index", path)
        return Index(path, np.vstack([rows, [*closing.row, container.chunk_count - 1]])), closing
    rows = np.array([(*record.row, chunk) for chunk, record in _all_records(container)], dtype=np.int64)
    return Index(path, _certain_rows(rows.reshape(-1, len(COLUMNS)), closing is not None)), closing


def _certain_rows(rows: np.ndarray, closed: bool) -> np.ndarray:
    """Return the rows up to the last steps, and the start of a segment after these: a kill may have cut off the rest."""
    if closed:
        return rows
    written = np.flatnonzero(rows[:, KIND] == STEPS)
    last = int(written[-1]) + 1 if len(written) else 1
    starts = (rows[last : last + 1, KIND] == SNAPSHOTS) & (rows[last : last + 1, DETAIL] == START)
    return rows[: last + int(starts.sum())]


def _last_entry(container: Container) -> Entry | None:
    """Return the last message of the exact content, if it lies in the last chunk."""
    entries = container.messages(container.chunk_count - 1) if container.chunk_count else []
    return next((entry for entry in reversed(entries) if kind_of(entry.topic) is not None), None)


def _all_records(container: Container) -> Iterator[tuple[int, Record]]:
    for chunk, entry in container.all_messages():
        kind = kind_of(entry.topic)
        if kind is not None:
            yield chunk, decode(entry.message.data, kind, container.most_text)
