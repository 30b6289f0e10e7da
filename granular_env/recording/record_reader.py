"""The records of a log, found by its index: each is checked and decoded."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from ..components.errors import GranularError, LogError, ParameterError, nearest, one_line
from ..components.snapshot import Snapshot
from ..components.support.serialization import digest
from ..components.variables import Variable
from .container import NOT_A_LOG, PROFILE, Container, Limits
from .header import event_kinds_from, variable_from
from .index import CHUNK, DETAIL, FIRST, SEGMENT, find_index
from .records import FORMAT, FRAMES, HEADER, INCIDENTS, Record, damage, decode, kind_of, nanoseconds

_RECORDS_AT_HAND = 32


class RecordReader:
    """The records of a log: what its header says, and what each row of its index points at.

    Attributes:
        path: the file.
        limits: on what the file may ask for.
        container: the MCAP file.
        identity: eight bytes, in hex, that no other log shares.
        header, header_arrays: the content of the first record, not checked further than what follows here.
        step_size: length of a tick [s].
        elapsed: age of the parent where a branch begins, in ticks; 0 where there is no parent.
        variables, input_variables: what was recorded, and all inputs, by name.
        index: a row for each record.
        closing: the last record of a log that was closed; else None.
    """

    def __init__(self, path: Path, allow_large: bool = False, scan: bool = False) -> None:
        """Open the file; with `scan`, go through it from the front even where it has a summary."""
        self.path, self.limits = path, Limits(str(path), allow_large)
        self.container = Container(path, self.limits, scan)
        try:
            self._read_header()
            self.index, self.closing = find_index(self.container)
        except GranularError as error:
            self.container.close()
            raise error.of(self.source) from error.__cause__
        self._first_row = np.searchsorted(self.index.rows[:, CHUNK], np.arange(self.container.chunk_count + 1))
        self._at_hand: dict[int, Record] = {}

    def _read_header(self) -> None:
        entries = self.container.messages(0) if self.container.chunk_count else []
        first = next((entry for entry in entries if kind_of(entry.topic) is not None), None)
        if first is None or kind_of(first.topic) != HEADER:
            why = f": {self.container.damage}" if self.container.damage else ""
            raise LogError(f"{NOT_A_LOG}{why}", hint=self.container.advice, source=repr(str(self.path)))
        self.identity = digest(first.message.data).hex()
        record = decode(first.message.data, HEADER, self.container.most_text)
        self.header, self.header_arrays = record.header, record.arrays
        found = self.header.get("format")
        if found != FORMAT:
            advice = f"record it again, or read it with an older {PROFILE}" if found in range(FORMAT) else f"update {PROFILE}"
            expected = f"{FORMAT}, the format that this program reads"
            raise LogError(f"got {found!r}", expected=expected, hint=advice, at="header.format", source=self.source)
        step_size, elapsed = self.header.get("step_size"), self.header.get("elapsed")
        if not isinstance(step_size, float) or not math.isfinite(step_size) or step_size <= 0.0:
            raise LogError(f"the log's header has step_size {step_size!r}", expected="seconds")
        if not isinstance(elapsed, int) or not 0 <= elapsed < 2**53:
            raise damage("it does not say how old the parent was", "header.elapsed", self.path)
        self.step_size, self.elapsed = step_size, int(elapsed)
        recorded, inputs = self.header.get("variables"), self.header.get("inputs")
        if not isinstance(recorded, list) or not isinstance(inputs, list):
            raise damage("it does not say what was recorded", "header.variables", self.path)
        self.variables: dict[str, Variable] = {v.name: v for v in map(variable_from, recorded)}
        self.input_variables: dict[str, Variable] = {v.name: v for v in map(variable_from, inputs)}
        self._numbers = {name: number for number, name in enumerate(self.variables)}

    @property
    def closing_header(self) -> Mapping[str, Any]:
        """Return what the closing record says: report, conclusions, cautions; nothing where there is none."""
        return self.closing.header if self.closing is not None else {}

    def close(self) -> None:
        """Close the file."""
        self.container.close()

    @property
    def source(self) -> str:
        """Name of the log in messages."""
        return f"log {str(self.path)!r}"

    @contextmanager
    def name_file_in_errors(self) -> Iterator[None]:
        """Add the name of the log to errors of the block."""
        try:
            yield
        except GranularError as error:
            raise error.of(self.source) from error.__cause__

    # -- rows and times ---------------------------------------------------------------------------------------------

    @property
    def start_tick(self) -> int:
        """Tick at which the log's time begins: 0, or later for a branch."""
        return self.index.segments[0].start if self.index.segments else 0

    @property
    def end_tick(self) -> int:
        """Tick at which the log's time ends, segments laid end to end."""
        return self.start_tick + sum(segment.end - segment.start for segment in self.index.segments)

    def log_tick(self, segment: int, tick: Any) -> Any:
        """Return the tick in the log's time, which lays segments end to end, of one or more ticks of a segment."""
        own = self.index.all_segments[int(segment)]
        return tick - own.start + own.elapsed + self.start_tick

    def nanoseconds(self, tick: int) -> int:
        """Return the time of a message at a tick of the log's time; a branch counts on from its parent's age."""
        return nanoseconds(tick - self.start_tick + self.elapsed, self.step_size)

    def rows(self, kind: int) -> np.ndarray:
        """Return the rows of a kind, in segments where something happened; of incidents, all."""
        rows = self.index.select(kind)
        if kind == INCIDENTS:
            return rows
        return rows[np.isin(rows[:, SEGMENT], [segment.number for segment in self.index.segments])]

    def frame_rows(self, name: str) -> np.ndarray:
        """Return the rows of the frames of a variable; `ParameterError` where it was not recorded."""
        if name not in self._numbers:
            hint = nearest(str(name), self._numbers)
            raise ParameterError(f"got {one_line(name)}", expected="a variable that was recorded", hint=hint, at="variable")
        rows = self.rows(FRAMES)
        return rows[rows[:, DETAIL] == self._numbers[name]]

    # -- what rows point at -----------------------------------------------------------------------------------------

    def read(self, row: np.ndarray) -> Record:
        """Return the record that a row of the index points at; `LogError` where the file holds another one there."""
        chunk = int(row[CHUNK])
        first, last = self._first_row[chunk : chunk + 2].tolist()
        place = first + int(np.flatnonzero((self.index.rows[first:last] == row).all(axis=1))[0])
        known = self._at_hand.get(place)
        if known is None:
            entries = [entry for entry in self.container.messages(chunk) if kind_of(entry.topic) is not None]
            # Of a log that was not closed, the index leaves out what follows the last steps.
            if len(entries) < last - first:
                raise damage("records are missing or doubled", "index", self.path)
            entry = entries[place - first]
            with self.name_file_in_errors():
                known = decode(entry.message.data, kind_of(entry.topic) or HEADER, self.container.most_text)
            if known.row != tuple(row[:CHUNK].tolist()):
                hint = "the file was put together"
                raise LogError("it names another record than there is", hint=hint, at="index", source=self.source)
            if len(self._at_hand) >= _RECORDS_AT_HAND:
                self._at_hand.pop(next(iter(self._at_hand)))
            self._at_hand[place] = known
        return known

    def frames(self, row: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return ticks, shape (frames,), and values, shape (frames, ...), of the frames of a variable in one record."""
        record, shape = self.read(row), self.variables[name].shape
        ticks, values = record.arrays["ticks"], record.arrays["values"]
        sound = ticks.shape == (record.count,) and len(values) == record.count * math.prod(shape)
        if not sound or (np.diff(ticks) <= 0).any() or (ticks[0], ticks[-1]) != (record.first, record.last):
            raise damage("a record has the wrong form", ("frames", name), self.path)
        return ticks, values.reshape(record.count, *shape)

    def event_rows(self, row: np.ndarray) -> np.ndarray:
        """Return the events of one record, shape (events, 5), as `events.event_rows` says."""
        record = self.read(row)
        rows = record.arrays.get("rows")
        if not self._are_events(rows) or len(rows) != record.count or rows[0, 0] != record.first or rows[-1, 0] != record.last:
            raise damage("a record has the wrong form", "events", self.path)
        return rows

    def _are_events(self, rows: Any) -> TypeGuard[np.ndarray]:
        """Return whether these are rows as `events.event_rows` says, in the order of time, of kinds that there are."""
        if rows is None or rows.dtype != np.float64 or rows.ndim != 2 or rows.shape[1] != 5:
            return False
        ticks, kinds, places = rows[:, :3].T
        known = len(event_kinds_from(self.header, self.path))
        sound = bool((rows[:, :3] == np.rint(rows[:, :3])).all() and (kinds >= 0).all() and (kinds < known).all())
        return sound and bool((np.abs(places) < 2**53).all() and (ticks >= 0).all() and (np.diff(ticks) >= 0).all())

    def hash_rows(self, row: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
        """Return ticks, shape (hashes,), and digests, shape (hashes, width), of one record."""
        record = self.read(row)
        ticks, rows = record.arrays.get("ticks"), record.arrays.get("rows")
        if ticks is None or rows is None or rows.shape != (record.count, width) or ticks.shape != (record.count,):
            raise damage("a record has the wrong form", "hashes", self.path)
        if rows.dtype != np.int64 or ticks.dtype != np.int64 or (np.diff(ticks) <= 0).any() or ticks[0] < row[FIRST]:
            raise damage("a record has the wrong form", "hashes", self.path)
        return ticks, rows

    def snapshot(self, row: np.ndarray) -> Snapshot:
        """Return the snapshot that a row points at."""
        data = self.read(row).arrays.get("snapshot")
        if data is None or data.dtype != np.uint8 or data.ndim != 1:
            raise damage("one has the wrong form", "snapshots", self.path)
        with self.name_file_in_errors():
            snapshot = Snapshot.from_bytes(data.tobytes(), self.container.most_text)
        if snapshot.tick != row[FIRST]:
            raise damage(f"one is of tick {snapshot.tick}, its place says {row[FIRST]}", "snapshots", self.path)
        if not set(self.input_variables) <= snapshot.inputs.keys():
            raise damage("one lacks an input", "snapshots", self.path)
        return snapshot
