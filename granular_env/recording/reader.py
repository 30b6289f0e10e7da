"""The content of a log: what was recorded, by variable and time; its index, its steps and its snapshots."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, Self

import numpy as np

from ..components.component import refuse_unknown_events
from ..components.contract import Event, EventDetail, Variable
from ..components.drawables import Drawable
from ..components.errors import GranularError, LogError, ParameterError, nearest, one_line
from ..components.profiles import CompiledProfile
from ..components.snapshot import Snapshot
from ..output_files import count_of
from . import step_history
from .drawables import drawables_from
from .header import BalanceNames, balance_names_from, variable_from
from .limits import Limits
from .mcap_reader import NOT_A_LOG, McapReader
from .message_index import CHUNK, COUNT, DETAIL, FIRST, SEGMENT, Segment, find_index
from .records import (
    EVENTS,
    FORMAT,
    FRAMES,
    HEADER,
    INCIDENTS,
    PROFILE,
    SNAPSHOTS,
    STEPS,
    TOPICS,
    Record,
    damage,
    decode,
    log_identity,
    nanoseconds,
)
from .step_history import StepHistory

_RECORDS_AT_HAND = 32


class LogReader:
    """The content of a log: what was recorded, by variable and time, and what it says of the run.

    Times are those of the component. Where it was reset or restored in between, the log has several *segments*, laid end
    to end: times go on from segment to segment, so every moment of the run has its own.

    Attributes:
        path: the file.
        complete: False where the writer was killed before it could close the file.
        variables: recorded name -> `Variable`.
        step_size: length of a tick [s].
    """

    def __init__(self, path: Any, allow_large: bool = False, scan: bool = False) -> None:
        """Use `open_log`; with `scan`, go through the file from the front even where it has a summary."""
        self.path = path
        self._caps = Limits(str(path), allow_large)
        self._container = McapReader(path, self._caps, scan)
        try:
            self._read_header()
            self._index, self._closing = find_index(self._container, self._log)
        except GranularError as error:
            self._container.close()
            raise error.of(self._source) from error.__cause__
        self.complete = self._container.complete
        rows = self._index.rows[:, CHUNK]
        self._first_row = np.searchsorted(rows, np.arange(self._container.chunk_count + 1))
        self._at_hand: OrderedDict[int, Record] = OrderedDict()

    def _read_header(self) -> None:
        messages = self._container.messages(0) if self._container.chunk_count else []
        first = next((m for m in messages if m.topic in TOPICS), None)
        if first is None or TOPICS[first.topic] != HEADER:
            why = f": {self._container.damage}" if self._container.damage else ""
            raise LogError(f"{NOT_A_LOG}{why}", hint=self._container.advice, source=f"{str(self.path)!r}")
        self._log = log_identity(first.data)
        record = decode(first.data, HEADER, None, self._container.most_text)
        self._header, self._header_arrays = record.header, record.arrays
        if self._header.get("format") != FORMAT:
            found = self._header.get("format")
            advice = f"record it anew, or read it with an older {PROFILE}" if found in range(FORMAT) else f"update {PROFILE}"
            raise LogError(
                f"got {found!r}", expected=f"{FORMAT}, the format that this program reads",
                hint=advice, at="header.format", source=self._source,
            )  # fmt: skip
        self.step_size = step_history.finite_step(self._header.get("step_size"))
        elapsed = self._header.get("elapsed")
        if not isinstance(elapsed, int) or not 0 <= elapsed < 2**53:
            raise damage("it does not say how old the parent was", "header.elapsed", self.path)
        self._elapsed = int(elapsed)
        recorded, inputs = self._header.get("variables"), self._header.get("inputs")
        if not isinstance(recorded, list) or not isinstance(inputs, list):
            raise damage("it does not say what was recorded", "header.variables", self.path)
        self.variables: dict[str, Variable] = {v.name: v for v in map(variable_from, recorded)}
        self.input_variables: dict[str, Variable] = {v.name: v for v in map(variable_from, inputs)}
        self._numbers = {name: number for number, name in enumerate(self.variables)}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        size = f"{count_of(self.calls, 'call')}, {count_of(self.end_tick - self.start_tick, 'tick')}, {self.duration:g} s"
        return f"<Log {str(self.path)!r}: {self._header.get('component')}, {size}, {state}>"

    def close(self) -> None:
        """Close the file."""
        self._container.close()

    # -- what it is -------------------------------------------------------------------------------------------------

    @property
    def identity(self) -> str:
        """Eight bytes, in hex, that no other log shares; a branch names its parent by it."""
        return self._log

    @property
    def metadata(self) -> dict[str, Any]:
        """Component, parameters, experiment, versions, machine, options, events; and report and cautions if it was closed."""
        found = dict(self._header)
        found["complete"] = self.complete
        found["damage"] = self._container.damage
        found["incidents"] = [dict(self._record(row).header) for row in self._rows(INCIDENTS) if row[DETAIL] == 0]
        closing = self._closing.header if self._closing is not None else {}
        found["report"], found["cautions"] = closing.get("report", {}), closing.get("cautions", [])
        return found

    @property
    def size(self) -> int:
        """Bytes of the file."""
        return self._container.size

    @property
    def segments(self) -> list[Segment]:
        """Unbroken histories in which something happened."""
        return self._index.segments

    @property
    def calls(self) -> int:
        """Number of calls of `step` that it holds."""
        return int(self._rows(STEPS)[:, COUNT].sum())

    @property
    def start_tick(self) -> int:
        """Tick at which the log's time begins: 0, or later for a branch."""
        return self.segments[0].start if self.segments else 0

    @property
    def end_tick(self) -> int:
        """Tick at which the log's time ends, segments laid end to end."""
        return self.start_tick + sum(segment.end - segment.start for segment in self.segments)

    @property
    def duration(self) -> float:
        """Simulated time that it holds [s]."""
        return (self.end_tick - self.start_tick) * self.step_size

    @cached_property
    def drawables(self) -> tuple[Drawable, ...]:
        """Return what a viewer can draw."""
        with self._name_file_in_errors():
            return drawables_from(self._header.get("drawables"), self._header_arrays, self.variables)

    @cached_property
    def balances(self) -> tuple[BalanceNames, ...]:
        """The names behind each balance; each is a recorded variable."""
        with self._name_file_in_errors():
            return balance_names_from(self._header.get("balances"))

    def events(self, kind: str | None = None, index: int | None = None) -> list[Event]:
        """Return what happened to the component in the run, in the log's ticks and the order of time.

        Args:
            kind: only of this kind; see `event_kinds`.
            index: only of this link, cell, ...

        Raises:
            ParameterError: there is no such kind, or the index is none.
        """
        kinds = list(self.event_kinds)
        refuse_unknown_events(kinds, kind, index, "")
        found = []
        for row in self._rows(EVENTS):
            for tick, number, place, value, limit in self._event_rows(row).tolist():
                event = Event(int(self._log_tick(row[SEGMENT], int(tick))), kinds[int(number)],
                              None if place < 0 else int(place), value, limit)  # fmt: skip
                if kind in (None, event.kind) and index in (None, event.index):
                    found.append(event)
        return found

    @property
    def event_kinds(self) -> dict[str, str]:
        """Kinds of events that can happen -> what they are."""
        kinds = self._header.get("event_kinds")
        if not isinstance(kinds, dict) or not all(isinstance(text, str) for text in kinds.values()):
            raise damage("it does not say what can happen", "header.event_kinds", self.path)
        return dict(kinds)

    @property
    def event_details(self) -> dict[str, EventDetail]:
        """Units of some or all of these kinds, and what their indices count; see `contract.EventDetail`."""
        details = self._header.get("event_details", {})
        try:
            found = {kind: EventDetail(**detail) for kind, detail in details.items()}
        except (AttributeError, TypeError):
            found = {"": EventDetail(counts=None)}  # type: ignore[arg-type]
        if not all(isinstance(text, str) for one in found.values() for text in (one.unit, one.counts)):
            raise damage("it does not say what its events count", "header.event_details", self.path)
        return found

    # -- frames -----------------------------------------------------------------------------------------------------

    def ticks(self, name: str) -> np.ndarray:
        """Ticks of the frames of a variable, in the log's time, shape (frames,), int64."""
        rows = self._frame_rows(name)
        parts = [self._log_tick(row[SEGMENT], self._frames(row, name)[0]) for row in rows]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)

    def times(self, name: str) -> np.ndarray:
        """Return times of the frames of a variable, shape (frames,) [s]."""
        return self.ticks(name) * self.step_size

    def series(self, name: str, segment: Segment | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return times (frames,) [s] and values (frames, ...) of a variable; of one segment, where one is given."""
        rows = self._frame_rows(name)
        rows = rows if segment is None else rows[rows[:, SEGMENT] == segment.number]
        shape = self.variables[name].shape
        count = int(rows[:, COUNT].sum())
        self._caps.series(count * 8 * int(np.prod(shape, dtype=object)))
        ticks, values, filled = np.empty(count, np.int64), None, 0
        for row in rows:
            own_ticks, own = self._frames(row, name)
            # Allocated only once a frame of that shape has been seen to exist.
            values = np.empty((count, *shape)) if values is None else values
            place = slice(filled, filled + len(own))
            ticks[place], values[place] = self._log_tick(row[SEGMENT], own_ticks), own
            filled += len(own)
        return ticks * self.step_size, np.empty((0, *shape)) if values is None else values

    def get(self, name: str, time: float) -> Any:
        """Return the frame of a variable at a time [s], or the last one before it: a number, or an array of its shape.

        Raises:
            ParameterError: the variable was not recorded, or the time is outside of the log.
        """
        tick = self._tick_at(time)
        rows = self._frame_rows(name)
        if not len(rows):
            raise LogError("it holds none of this variable", at=("frames", name), source=self._source)
        firsts = np.array([self._log_tick(row[SEGMENT], row[FIRST]) for row in rows])
        place = int(np.searchsorted(firsts, tick, side="right")) - 1
        if place < 0:
            raise ParameterError(
                f"got {time:g} s, the first frame of {name!r} is at {firsts[0] * self.step_size:g} s", at="time"
            )
        if tick > self.end_tick:
            raise self._outside(time)
        ticks, values = self._frames(rows[place], name)
        own = int(np.searchsorted(self._log_tick(rows[place][SEGMENT], ticks), tick, side="right")) - 1
        value = values[own]
        return float(value) if value.ndim == 0 else value.copy()

    def to_numpy(self, name: str) -> np.ndarray:
        """All frames of a variable, shape (frames, ...)."""
        return self.series(name)[1]

    def to_xarray(self) -> Any:
        """Return all frames as an `xarray.Dataset` over time.

        Variables that count the same things, such as grains, share that dimension, which has the numbers from 0 as its
        coordinate: ``data.velocity * data.displacement`` has the dimensions (time, grain). Units and descriptions are in the
        attributes.

        Raises:
            MissingExtraError: xarray is not installed.
            LogError: the variables were not recorded at the same times.
        """
        from .dataset import dataset_of

        return dataset_of(self)

    # -- inputs, steps, snapshots -----------------------------------------------------------------------------------

    @property
    def inputs(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Every input's course: times [s] and values, at each change; profiles are sampled. `steps_of` has them exactly."""
        found = {}
        for name in self.input_variables:
            ticks, values = [], []
            for segment in self.segments:
                held = self.snapshot(segment, segment.start).inputs
                own, samples = step_history.sample_input(self.steps_of(segment), held, name, segment.end)
                ticks.append(self._log_tick(segment.number, own))
                values.append(samples)
            nothing = np.zeros(0), np.zeros((0, *self.input_variables[name].shape))
            found[name] = (np.concatenate(ticks) * self.step_size, np.concatenate(values)) if ticks else nothing
        return found

    def steps_of(self, segment: Segment) -> StepHistory:
        """Every call of `step` in a segment, exactly."""
        return self._steps[segment.number]

    @property
    def snapshots(self) -> list[tuple[Segment, int]]:
        """Return where snapshots are: segment and tick; `snapshot` reads one."""
        by_number = {segment.number: segment for segment in self.segments}
        return [(by_number[row[SEGMENT]], int(row[FIRST])) for row in self._rows(SNAPSHOTS).tolist()]

    def snapshot(self, segment: Segment, tick: int) -> Snapshot:
        """Return the snapshot of a segment at that tick, or the last one before."""
        rows = self._index.select(SNAPSHOTS, None, segment.number)
        rows = rows[rows[:, FIRST] <= tick]
        if not len(rows):
            raise damage(f"none at or before tick {tick}", "snapshots", self.path)
        return self._snapshot(rows[np.argmax(rows[:, FIRST])])

    def locate(self, time: float) -> tuple[Segment, int]:
        """Segment and its own tick at a time [s] of the log; where two segments meet, the later one."""
        tick = self._tick_at(time)
        if not self.start_tick <= tick <= self.end_tick or not self.segments:
            raise self._outside(time)
        segment = next(s for s in reversed(self.segments) if self._log_tick(s.number, s.start) <= tick)
        return segment, tick - self._log_tick(segment.number, 0)

    # -- details ----------------------------------------------------------------------------------------------------

    @property
    def _source(self) -> str:
        return f"log {str(self.path)!r}"

    @contextmanager
    def _name_file_in_errors(self) -> Iterator[None]:
        try:
            yield
        except GranularError as error:
            raise error.of(self._source) from error.__cause__

    def _outside(self, time: float) -> ParameterError:
        first, last = self.start_tick * self.step_size, self.end_tick * self.step_size
        return ParameterError(f"got {time:.12g} s, the log goes from {first:.12g} s to {last:.12g} s", at="time")

    def _tick_at(self, time: float) -> int:
        try:
            return round(float(time) / self.step_size)
        except (TypeError, ValueError, OverflowError) as error:
            raise ParameterError(f"got {time!r}", expected="seconds", at="time") from error

    def _log_tick(self, segment: int, tick: Any) -> Any:
        own = self._index.all_segments[int(segment)]
        return tick - own.start + own.elapsed + self.start_tick

    def _rows(self, kind: int) -> np.ndarray:
        """Rows of a kind in segments where something happened."""
        rows = self._index.select(kind)
        return rows[np.isin(rows[:, SEGMENT], [segment.number for segment in self.segments])] if kind != INCIDENTS else rows

    def _nanoseconds(self, tick: int) -> int:
        """Return the time of a message at a tick of the log's time; a branch counts on from its parent's age."""
        return nanoseconds(tick - self.start_tick + self._elapsed, self.step_size)

    def _frame_rows(self, name: str) -> np.ndarray:
        if name not in self._numbers:
            hint = nearest(str(name), self._numbers)
            raise ParameterError(f"got {one_line(name)}", expected="a variable that was recorded", hint=hint, at="variable")
        rows = self._rows(FRAMES)
        return rows[rows[:, DETAIL] == self._numbers[name]]

    def _frames(self, row: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
        record = self._record(row)
        ticks, values = record.arrays.get("ticks"), record.arrays.get("values")
        shape = self.variables[name].shape
        if ticks is None or values is None or ticks.dtype != np.int64 or values.dtype != np.float64:
            raise damage("a record has the wrong form", ("frames", name), self.path)
        if ticks.shape != (record.count,) or values.shape != (record.count, *shape) or (np.diff(ticks) <= 0).any():
            raise damage("a record has the wrong form", ("frames", name), self.path)
        if ticks[0] != record.first or ticks[-1] != record.last:
            raise damage("a record has other ticks than the index says", ("frames", name), self.path)
        return ticks, values

    def _event_rows(self, row: np.ndarray) -> np.ndarray:
        """Return the events of one record, shape (events, 5)."""
        record = self._record(row)
        rows, sound = record.arrays.get("rows"), False
        if rows is not None and rows.dtype == np.float64 and rows.shape == (record.count, 5):
            ticks, numbers = rows[:, 0], rows[:, 1:3]
            sound = ticks[0] == record.first and ticks[-1] == record.last and bool((np.diff(ticks) >= 0).all())
            sound = sound and bool((numbers == np.rint(numbers)).all() and (numbers[:, 0] >= 0).all())
            sound = sound and bool((numbers[:, 0] < len(self.event_kinds)).all() and (np.abs(numbers[:, 1]) < 2**53).all())
        if not sound:
            raise damage("a record has the wrong form", "events", self.path)
        return rows  # type: ignore[return-value]

    def _snapshot(self, row: np.ndarray) -> Snapshot:
        data = self._record(row).arrays.get("snapshot")
        if data is None or data.dtype != np.uint8 or data.ndim != 1:
            raise damage("one has the wrong form", "snapshots", self.path)
        with self._name_file_in_errors():
            snapshot = Snapshot.from_bytes(data.tobytes(), self._container.most_text)
        if snapshot.tick != row[FIRST]:
            raise damage(f"one is of tick {snapshot.tick}, its place says {row[FIRST]}", "snapshots", self.path)
        if not set(self.input_variables) <= snapshot.inputs.keys():
            raise damage("one lacks an input", "snapshots", self.path)
        return snapshot

    def _record(self, row: np.ndarray) -> Record:
        """Return the record that a row of the index points at."""
        chunk = int(row[CHUNK])
        first, last = self._first_row[chunk : chunk + 2]
        place = first + int(np.flatnonzero((self._index.rows[first:last] == row).all(axis=1))[0])
        known = self._at_hand.get(int(place))
        if known is None:
            messages = [m for m in self._container.messages(chunk) if m.topic in TOPICS]
            if len(messages) != last - first:
                raise damage("records are missing or doubled", "index", self.path)
            message = messages[place - first]
            kind = TOPICS[message.topic]
            with self._name_file_in_errors():
                known = decode(message.data, kind, self._log if kind != HEADER else None, self._container.most_text)
            if known.row != tuple(row[:CHUNK].tolist()):
                raise LogError(
                    "it names another record than there is", hint="the file was put together", at="index", source=self._source
                )
            self._at_hand[int(place)] = known
            if len(self._at_hand) > _RECORDS_AT_HAND:
                self._at_hand.popitem(last=False)
        return known

    @property
    def _steps(self) -> dict[int, StepHistory]:
        return self._program[0]

    @cached_property
    def _program(self) -> tuple[dict[int, StepHistory], list[CompiledProfile]]:
        """The steps of each segment, and all profiles by their number."""
        rows = self._index.select(STEPS)
        self._caps.series(int(rows[:, COUNT].sum()) * 16)
        profiles: list[CompiledProfile] = []
        found = {}
        for segment in self._index.all_segments:
            records = [self._record(row) for row in self._index.select(STEPS, None, segment.number)]
            shapes = {name: variable.shape for name, variable in self.input_variables.items()}
            with self._name_file_in_errors():
                found[segment.number] = step_history.steps_of(records, segment.start, shapes, profiles, self.step_size)
        return found, profiles
