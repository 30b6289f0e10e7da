"""The records of a log, found by its index, checked and decoded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..components.errors import GranularError, LogError, ParameterError, one_line, spelling_hint
from ..components.snapshot import Snapshot
from ..components.support.serialization import digest
from ..components.variables import Variable
from .container import NOT_A_LOG, Container, Limits
from .header import parse_variable
from .index import CHUNK, DETAIL, FIRST, KIND, PLACE, SEGMENT, find_index
from .records import (
    FORMAT,
    FRAMES,
    HEADER,
    INCIDENTS,
    PROFILE,
    Record,
    damage_error,
    decode_record,
    record_kind,
    to_nanoseconds,
)


class RecordReader:
    """A reader of a log's header and of the records listed in its index.

    Attributes:
        path: the file.
        source: name of the log in messages.
        limits: the limits on sizes in the file.
        container: the MCAP file.
        size: size of the file [bytes].
        identity: eight unique bytes in hex, by which a branch names its parent.
        header, header_arrays: content of the first record, of which only the parts used for the attributes below are checked.
        step_size: length of a tick (internal step) [s].
        elapsed: for a branch, number of ticks in its parent logs before its start; otherwise 0.
        variables: the recorded variables by name.
        input_variables: the inputs of the component by name.
        index: one row per record.
        closing: the record that closes the log; None for a log that was not closed.
        start_tick: start of the log's time: 0, or later for a branch.
        end_tick: end of the log's time, with concatenated segments.
    """

    def __init__(self, path: Path, allow_large: bool = False, scan: bool = False) -> None:
        """Open the file; with `scan`, scan it from the front even if it has a summary."""
        self.path, self.limits = path, Limits(str(path), allow_large)
        self.source = self.limits.source
        self.container = Container(path, self.limits, scan)
        self.size = self.container.size
        try:
            with self.name_file_in_errors():
                self._read_header()
                self.index, self.closing = find_index(self.container)
        except GranularError:
            self.close()
            raise
        segments = self.index.segments
        self.start_tick = segments[0].start if segments else 0
        self.end_tick = self.start_tick + sum(segment.end - segment.start for segment in segments)

    def _read_header(self) -> None:
        entries = self.container.messages(0) if len(self.container.places) else []
        if not entries or record_kind(entries[0].topic) != HEADER:
            why = f": {self.container.damage}" if self.container.damage else ""
            raise LogError(f"{NOT_A_LOG}{why}", source=repr(str(self.path)))
        data = entries[0].message.data
        self.identity, record = digest(data).hex(), decode_record(data, HEADER, self.container.text_limit)
        self.header, self.header_arrays = record.header, record.arrays
        found, step_size, elapsed, recorded, inputs = map(
            self.header.get, ("format", "step_size", "elapsed", "variables", "inputs")
        )
        if found != FORMAT:
            advice = f"record it again, or read it with an older {PROFILE}" if found in range(FORMAT) else f"update {PROFILE}"
            expected = f"{FORMAT}, the format that this program reads"
            raise LogError(f"got {found!r}", expected=expected, hint=advice, at="header.format")
        if not isinstance(step_size, float) or not 0.0 < step_size < math.inf:
            raise LogError(f"the log's header has step_size {step_size!r}", expected="seconds")
        if type(elapsed) is not int or not 0 <= elapsed < 2**53:
            raise damage_error("the age of the parent is missing or invalid", "header.elapsed")
        if not isinstance(recorded, list) or not isinstance(inputs, list):
            raise damage_error("the list of recorded variables is invalid", "header.variables")
        self.step_size, self.elapsed = step_size, elapsed
        self.variables: dict[str, Variable] = {v.name: v for v in map(parse_variable, recorded)}
        self.input_variables: dict[str, Variable] = {v.name: v for v in map(parse_variable, inputs)}

    def close(self) -> None:
        """Close the file."""
        self.container.close()

    @contextmanager
    def name_file_in_errors(self) -> Iterator[None]:
        """Add the name of the log to errors raised in the block."""
        try:
            yield
        except GranularError as error:
            raise error.with_source(self.source) from error.__cause__

    @property
    def event_kinds(self) -> dict[str, str]:
        """The description of each kind of event that the component can have."""
        kinds = self.header.get("event_kinds")
        if not isinstance(kinds, dict) or not all(isinstance(text, str) for text in kinds.values()):
            raise damage_error("the list of possible events is invalid", "header.event_kinds", self.path)
        return kinds

    def log_tick(self, segment: int, tick: Any) -> Any:
        """Convert one or more ticks of a segment to ticks of the log's time, in which the segments are concatenated."""
        own = self.index.all_segments[int(segment)]
        return tick - own.start + own.elapsed + self.start_tick

    def nanoseconds(self, tick: int) -> int:
        """Return the message time [ns] at a tick of the log's time; for a branch it includes the ticks of its parents."""
        return to_nanoseconds(tick - self.start_tick + self.elapsed, self.step_size)

    def rows(self, kind: int) -> np.ndarray:
        """Return the index rows of a kind of record in non-empty segments; of incidents, all rows."""
        rows = self.index.select_rows(kind)
        if kind == INCIDENTS:
            return rows
        return rows[np.isin(rows[:, SEGMENT], [segment.number for segment in self.index.segments])]

    def frame_rows(self, name: str) -> np.ndarray:
        """Return the index rows of the records with frames of a variable; `ParameterError` if it was not recorded."""
        names = list(self.variables)
        if name not in names:
            hint = spelling_hint(str(name), names)
            raise ParameterError(f"got {one_line(name)}", expected="a recorded variable", hint=hint, at="variable")
        rows = self.rows(FRAMES)
        return rows[rows[:, DETAIL] == names.index(name)]

    def read_record(self, row: np.ndarray) -> Record:
        """Return the record of an index row; `LogError` if the file contains a different record there."""
        entries, place = self.container.messages(int(row[CHUNK])), int(row[PLACE])
        if place >= len(entries):
            raise damage_error("records are missing", "index", self.path)
        with self.name_file_in_errors():
            record = decode_record(entries[place].message.data, int(row[KIND]), self.container.text_limit)
        if record_kind(entries[place].topic) != record.kind or record.row != tuple(row[:CHUNK].tolist()):
            raise LogError(
                "it refers to a different record", hint="parts of the file were replaced", at="index", source=self.source
            )
        return record

    def frames(self, row: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return ticks, shape (frames,), and values, shape (frames, ...), of a variable's frames in a record."""
        record, shape = self.read_record(row), self.variables[name].shape
        ticks, values = record.arrays["ticks"], record.arrays["values"]
        sound = ticks.shape == (record.count,) and len(values) == record.count * math.prod(shape)
        if not sound or (np.diff(ticks) <= 0).any() or (ticks[0], ticks[-1]) != (record.first, record.last):
            raise damage_error("a record has the wrong form", ("frames", name), self.path)
        return ticks, values.reshape(record.count, *shape)

    def event_rows(self, row: np.ndarray) -> np.ndarray:
        """Return the events of a record, shape (events, 5), in the layout of `events.event_rows`."""
        record = self.read_record(row)
        rows = record.arrays.get("rows")
        if rows is None or rows.dtype != np.float64 or rows.shape != (record.count, 5):
            raise damage_error("a record has the wrong form", "events", self.path)
        ticks, kinds, places = rows[:, :3].T
        is_sound = (rows[:, :3] == np.rint(rows[:, :3])) & (np.abs(rows[:, :3]) < 2**53)
        in_range = (kinds >= 0) & (kinds < len(self.event_kinds)) & (ticks >= record.first) & (ticks <= record.last)
        if not is_sound.all() or not in_range.all() or (np.diff(ticks) < 0).any():
            raise damage_error("a record has the wrong form", "events", self.path)
        return rows

    def hash_rows(self, row: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
        """Return ticks, shape (hashes,), and digests, shape (hashes, width), of a record."""
        record = self.read_record(row)
        ticks, rows = record.arrays.get("ticks"), record.arrays.get("rows")
        if ticks is None or rows is None or rows.shape != (record.count, width) or ticks.shape != (record.count,):
            raise damage_error("a record has the wrong form", "hashes", self.path)
        if rows.dtype != np.int64 or ticks.dtype != np.int64 or (np.diff(ticks) <= 0).any() or ticks[0] < record.first:
            raise damage_error("a record has the wrong form", "hashes", self.path)
        return ticks, rows

    def read_snapshot(self, row: np.ndarray) -> Snapshot:
        """Return the snapshot of an index row."""
        data = self.read_record(row).arrays.get("snapshot")
        if data is None or data.dtype != np.uint8 or data.ndim != 1:
            raise damage_error("a snapshot has the wrong form", "snapshots", self.path)
        with self.name_file_in_errors():
            snapshot = Snapshot.from_bytes(data.tobytes(), self.container.text_limit)
        if snapshot.tick != row[FIRST]:
            raise damage_error(f"tick {snapshot.tick} differs from tick {row[FIRST]} in the index", "snapshots", self.path)
        if not set(self.input_variables) <= snapshot.inputs.keys():
            raise damage_error("a snapshot lacks an input", "snapshots", self.path)
        return snapshot
