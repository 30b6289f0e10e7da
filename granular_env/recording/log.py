"""The content of a log: what was recorded, by variable and time; its index, its steps and its snapshots."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from ..components.component import Component
from ..components.drawables import Drawable
from ..components.errors import GranularError, LogError, ParameterError, one_line
from ..components.events import Event, EventDetail, refuse_unknown_events
from ..components.inputs import input_value
from ..components.profiles import CompiledProfile
from ..components.snapshot import Snapshot
from ..components.support.memory_limits import refuse_beyond
from ..output_files import count_of
from . import steps as step_history
from .branch import Branch, branch_of
from .container import Limits
from .drawables import drawables_from
from .header import BalanceNames, balance_names_from, event_kinds_from, table_of
from .index import COUNT, DETAIL, FIRST, SEGMENT, Segment
from .record_reader import RecordReader
from .records import EVENTS, INCIDENTS, SNAPSHOTS, STEPS, damage
from .rerun import build, restore
from .steps import StepHistory, Stretch
from .writer import as_path

# What reading one variable, or all the steps, may allocate [bytes].
_MOST_BYTES = 8 << 30


def open_log(
    path: str | os.PathLike[str], *, allow_large: bool = False, components: Mapping[str, type[Component]] | None = None
) -> Log:
    """Open a log; nothing but its index is read until it is asked for.

    Args:
        path: an MCAP file that `record` wrote; one whose writer was killed opens as far as it is intact.
        allow_large: lift the limits on sizes, for a file whose origin you trust.
        components: classes of components that are not ours, by name: a log alone never loads them.

    Raises:
        LogError: it is no log, or it is damaged.
    """
    log = Log(as_path(path), allow_large)
    log.components = components or {}
    return log


class Log:
    """A log, as `open_log` gives it: what was recorded, by variable and time, and the program that it is.

    Times are those of the component. Where it was reset or restored in between, the log has several *segments*, laid end
    to end: times go on from segment to segment, so every moment of the run has its own.

    Attributes:
        path: the file.
        complete: False where the writer was killed before it could close the file.
        variables: recorded name -> `Variable`.
        input_variables: the same of all inputs.
        step_size: length of a tick [s].
        records: header, index and records, for code that verifies, continues or recovers logs.
        components: classes of components that are not ours, by name, which it may be re-run with.
    """

    components: Mapping[str, type[Component]] = MappingProxyType({})

    def __init__(self, path: Path, allow_large: bool = False, scan: bool = False) -> None:
        """Use `open_log`; with `scan`, go through the file from the front even where it has a summary."""
        self.path = path
        self.records = records = RecordReader(path, allow_large, scan)
        self.complete = records.container.complete
        self.variables, self.input_variables, self.step_size = records.variables, records.input_variables, records.step_size

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        size = f"{count_of(self.calls, 'call')}, {count_of(self.end_tick - self.start_tick, 'tick')}, {self.duration:g} s"
        return f"<Log {str(self.path)!r}: {self.records.header.get('component')}, {size}, {state}>"

    def close(self) -> None:
        """Close the file."""
        self.records.close()

    # -- what it is -------------------------------------------------------------------------------------------------

    @property
    def identity(self) -> str:
        """Eight bytes, in hex, that no other log shares; a branch names its parent by it."""
        return self.records.identity

    @property
    def metadata(self) -> dict[str, Any]:
        """Component, parameters, experiment, versions, machine, options, kinds of events; at its end report and conclusions."""
        found = dict(self.records.header)
        found["complete"] = self.complete
        found["damage"] = self.records.container.damage
        closing = self.records.closing_header
        found |= {name: table_of(found.get(name)) for name in ("parameters", "versions", "machine")}
        found["report"] = table_of(closing.get("report"))
        return found | {name: _texts(closing.get(name)) for name in ("cautions", "conclusions")}

    @property
    def incidents(self) -> list[dict[str, Any]]:
        """Return the incidents of the run beside its steps.

        Each has a kind under "incident": "failed" and "interrupted", a step was undone; "unrecorded", steps are not in the log;
        "recovered" and "resumed", the log was.
        """
        return [dict(self.records.read(row).header) for row in self.records.rows(INCIDENTS) if row[DETAIL] == 0]

    @property
    def size(self) -> int:
        """Bytes of the file."""
        return self.records.container.size

    @property
    def segments(self) -> list[Segment]:
        """Unbroken histories in which something happened."""
        return self.records.index.segments

    @property
    def calls(self) -> int:
        """Number of calls of `step` that it holds."""
        return int(self.records.rows(STEPS)[:, COUNT].sum())

    @property
    def start_tick(self) -> int:
        """Tick at which the log's time begins: 0, or later for a branch."""
        return self.records.start_tick

    @property
    def end_tick(self) -> int:
        """Tick at which the log's time ends, segments laid end to end."""
        return self.records.end_tick

    @property
    def duration(self) -> float:
        """Simulated time that it holds [s]."""
        return (self.end_tick - self.start_tick) * self.step_size

    @cached_property
    def drawables(self) -> tuple[Drawable, ...]:
        """Return what a viewer can draw."""
        with self.records.name_file_in_errors():
            return drawables_from(self.records.header.get("drawables"), self.records.header_arrays, self.variables)

    @cached_property
    def balances(self) -> tuple[BalanceNames, ...]:
        """The names behind each balance; each is a recorded variable."""
        with self.records.name_file_in_errors():
            return balance_names_from(self.records.header.get("balances"))

    def events(self, kind: str | None = None, index: int | None = None) -> list[Event]:
        """Return what happened to the component in this log, in its ticks and the order of time; see `earlier_events`.

        Args:
            kind: only of this kind; see `event_kinds`.
            index: only of this link, cell, ...

        Raises:
            ParameterError: there is no such kind, or the index is none.
        """
        refuse_unknown_events(self.event_kinds, kind, index, "")
        found: list[Event] = []
        for row in self.records.rows(EVENTS):
            found += self._events_from(self.records.event_rows(row), row[SEGMENT])
        return _select(found, kind, index)

    def earlier_events(self, kind: str | None = None, index: int | None = None) -> list[Event] | None:
        """Return what had happened to the component before this log begins, such as before a branch; see `events`.

        Its component, in the state at the log's start, knows them.

        Returns:
            None where the component cannot be made here.
        """
        refuse_unknown_events(self.event_kinds, kind, index, "")
        return None if self._earlier_events is None else _select(self._earlier_events, kind, index)

    @cached_property
    def _earlier_events(self) -> list[Event] | None:
        if self.start_tick == 0 or not self.event_kinds:
            return []
        try:
            return self.component().events()
        except GranularError:
            return None

    def _events_from(self, rows: np.ndarray, segment: int) -> list[Event]:
        """Return events of a segment, in the log's ticks."""
        kinds = list(self.event_kinds)
        return [
            Event(int(self.records.log_tick(segment, int(tick))), kinds[int(number)], None if place < 0 else int(place), *rest)
            for tick, number, place, *rest in rows.tolist()
        ]

    @property
    def event_kinds(self) -> dict[str, str]:
        """Kinds of events that can happen -> what they are."""
        return event_kinds_from(self.records.header, self.path)

    @property
    def event_details(self) -> dict[str, EventDetail]:
        """Units of some or all of these kinds, and what their indices count; see `events.EventDetail`."""
        details = self.records.header.get("event_details", {})
        try:
            found = {kind: EventDetail(**detail) for kind, detail in details.items()}
        except (AttributeError, TypeError):
            found = {"": EventDetail(counts=None)}  # type: ignore[arg-type]
        if not all(isinstance(text, str) for one in found.values() for text in (one.unit, one.counts, one.ratio)):
            raise damage("it does not say what its events count", "header.event_details", self.path)
        return found

    # -- frames -----------------------------------------------------------------------------------------------------

    def ticks(self, name: str) -> np.ndarray:
        """Ticks of the frames of a variable, in the log's time, shape (frames,), int64."""
        rows = self.records.frame_rows(name)
        parts = [self.records.log_tick(row[SEGMENT], self.records.frames(row, name)[0]) for row in rows]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)

    def times(self, name: str) -> np.ndarray:
        """Return times of the frames of a variable, shape (frames,) [s]."""
        return self.ticks(name) * self.step_size

    def series(self, name: str, segment: Segment | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return times (frames,) [s] and values (frames, ...) of a variable; of one segment, where one is given."""
        if not isinstance(name, str):
            raise ParameterError(f"got {one_line(name)}", expected="the name of one variable", at="name")
        rows = self.records.frame_rows(name)
        rows = rows if segment is None else rows[rows[:, SEGMENT] == segment.number]
        shape = self.variables[name].shape
        count = int(rows[:, COUNT].sum())
        check_size(count * 8 * int(np.prod(shape, dtype=object)), self.records.limits)
        ticks, values, filled = np.empty(count, np.int64), None, 0
        for row in rows:
            own_ticks, own = self.records.frames(row, name)
            # Allocated only once a frame of that shape has been seen to exist.
            values = np.empty((count, *shape)) if values is None else values
            place = slice(filled, filled + len(own))
            ticks[place], values[place] = self.records.log_tick(row[SEGMENT], own_ticks), own
            filled += len(own)
        return ticks * self.step_size, np.empty((0, *shape)) if values is None else values

    def get(self, name: str, time: float) -> Any:
        """Return the frame of a variable at a time [s], or the last one before it: a number, or an array of its shape.

        Raises:
            ParameterError: the variable was not recorded, or the time is outside of the log.
        """
        tick = self._tick_at(time)
        rows = self.records.frame_rows(name)
        if not len(rows):
            raise LogError("it holds none of this variable", at=("frames", name), source=self.records.source)
        firsts = np.array([self.records.log_tick(row[SEGMENT], row[FIRST]) for row in rows])
        place = int(np.searchsorted(firsts, tick, side="right")) - 1
        if place < 0:
            raise ParameterError(
                f"got {time:g} s, the first frame of {name!r} is at {firsts[0] * self.step_size:g} s", at="time"
            )
        if tick > self.end_tick:
            raise self._outside(time)
        ticks, values = self.records.frames(rows[place], name)
        own = int(np.searchsorted(self.records.log_tick(rows[place][SEGMENT], ticks), tick, side="right")) - 1
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

        return dataset_of(self.variables, self.series, str(self.records.header.get("component")), self.records.source)

    # -- inputs, steps, snapshots -----------------------------------------------------------------------------------

    @property
    def inputs(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Every input's course: times [s] and values, at each change; profiles are sampled. `steps_of` has them exactly."""
        found = {}
        for name, variable in self.input_variables.items():
            ticks: list[int] = []
            values: list[Any] = []
            for one in self.input_stretches(name):
                own = one.sample_ticks()
                ticks += [tick + one.shift for tick in own]
                values += [input_value(one.value, tick) for tick in own]
            shaped = np.array(values, dtype=np.float64).reshape(len(values), *variable.shape)
            found[name] = (np.array(ticks, dtype=np.int64) * self.step_size, shaped)
        return found

    def input_stretches(self, name: str) -> Iterator[Stretch]:
        """Yield over which ticks an input was held at what, in order; nothing is sampled, whatever the size of the input."""
        for segment in self.segments:
            held = self.snapshot(segment, segment.start).inputs
            shift = int(self.records.log_tick(segment.number, 0))
            yield from step_history.stretches(self.steps_of(segment), held, name, segment.end, shift)

    def steps_of(self, segment: Segment) -> StepHistory:
        """Every call of `step` in a segment, exactly."""
        return self._steps[segment.number]

    @property
    def snapshots(self) -> list[tuple[Segment, int]]:
        """Return where snapshots are: segment and tick; `snapshot` reads one."""
        by_number = {segment.number: segment for segment in self.segments}
        return [(by_number[row[SEGMENT]], int(row[FIRST])) for row in self.records.rows(SNAPSHOTS).tolist()]

    def snapshot(self, segment: Segment, tick: int) -> Snapshot:
        """Return the snapshot of a segment at that tick, or the last one before."""
        rows = self.records.index.select(SNAPSHOTS, None, segment.number)
        rows = rows[rows[:, FIRST] <= tick]
        if not len(rows):
            raise damage(f"none at or before tick {tick}", "snapshots", self.path)
        return self.records.snapshot(rows[np.argmax(rows[:, FIRST])])

    def locate(self, time: float) -> tuple[Segment, int]:
        """Segment and its own tick at a time [s] of the log; where two segments meet, the later one."""
        tick = self._tick_at(time)
        if not self.start_tick <= tick <= self.end_tick or not self.segments:
            raise self._outside(time)
        segment = next(s for s in reversed(self.segments) if self.records.log_tick(s.number, s.start) <= tick)
        return segment, tick - self.records.log_tick(segment.number, 0)

    # -- the program ------------------------------------------------------------------------------------------------

    def component(self) -> Component:
        """Return a fresh component with the log's parameters, in the state at the log's start.

        Raises:
            LogError: the parameters do not give the identity that the log claims.
        """
        component = self.rebuilt()
        if component.identity != self.records.header.get("identity"):
            raise LogError(
                "its parameters do not give the identity it claims",
                hint=f"they were changed, or it is from another version of {component.name!r} (see `replay --verify`)",
                source=self.records.source,
            )
        if self.segments:
            restore(component, self.snapshot(self.segments[0], self.segments[0].start))
        return component

    def rebuilt(self) -> Component:
        """Return a fresh component with the log's parameters, its identity not compared and its state that of a reset."""
        return build(self.records.header, self.records.limits, self.components)

    def branch(self, at: float) -> Branch:
        """Return a component in the state at a time [s] of the log, and what the log did from there.

        A time between two steps is moved to the nearest; ``.component.time`` is the one that was taken.

        Raises:
            ParameterError: the time is outside of the log.
            LogError: the log cannot be re-run.
        """
        try:
            return branch_of(self, at)
        except ParameterError as error:
            raise error.renamed("time", "at") from None

    # -- details ----------------------------------------------------------------------------------------------------

    def _outside(self, time: float) -> ParameterError:
        first, last = self.start_tick * self.step_size, self.end_tick * self.step_size
        return ParameterError(f"got {time:.12g} s, the log goes from {first:.12g} s to {last:.12g} s", at="time")

    def _tick_at(self, time: float) -> int:
        try:
            return round(float(time) / self.step_size)
        except (TypeError, ValueError, OverflowError) as error:
            raise ParameterError(f"got {time!r}", expected="seconds", at="time") from error

    @cached_property
    def _steps(self) -> dict[int, StepHistory]:
        """The steps of each segment."""
        records = self.records
        check_size(int(records.index.select(STEPS)[:, COUNT].sum()) * 16, records.limits)
        shapes = {name: variable.shape for name, variable in self.input_variables.items()}
        profiles: list[CompiledProfile] = []
        found = {}
        for segment in records.index.all_segments:
            own = [records.read(row) for row in records.index.select(STEPS, None, segment.number)]
            with records.name_file_in_errors():
                found[segment.number] = step_history.steps_of(own, segment.start, shapes, profiles, self.step_size)
        return found


def check_size(size: int, limits: Limits) -> None:
    """Refuse to read arrays of so many bytes that a stranger's log says it has."""
    limits.check("the size of what was asked for, in bytes,", size, _MOST_BYTES)
    refuse_beyond(size, f"log {limits.path!r}: what was asked for", LogError)


def _select(events: Sequence[Event], kind: str | None, index: int | None) -> list[Event]:
    return [event for event in events if kind in (None, event.kind) and index in (None, event.index)]


def _texts(value: Any) -> list[str]:
    return [str(text) for text in value] if isinstance(value, list) else []
