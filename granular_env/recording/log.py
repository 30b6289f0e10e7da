"""A log opened for reading: recorded variables, events, snapshots, and the calls of `step` with their inputs."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..components.component import Component
from ..components.drawables import Drawable
from ..components.errors import GranularError, LogError, ParameterError, one_line
from ..components.events import Event, EventDetail, decode_events, refuse_unknown_events
from ..components.profiles import CompiledProfile
from ..components.snapshot import Snapshot
from ..components.support.html_summary import html_summary
from ..components.support.memory_limits import refuse_excess_memory
from ..output_files import count_text
from . import steps as step_history
from .branch import Branch, make_branch
from .container import Limits
from .drawables import parse_drawables
from .header import BalanceNames, header_table, parse_balance_names
from .index import COUNT, FIRST, SEGMENT, Segment
from .record_reader import RecordReader
from .records import EVENTS, INCIDENTS, SNAPSHOTS, STEPS, damage_error
from .replay import make_component, restore_snapshot
from .steps import InputInterval, StepHistory
from .writer import to_path

if TYPE_CHECKING:
    from ..progress import Progress
    from .export.formats import Export

# Limit on the memory for one variable, or for all steps [bytes].
_MOST_BYTES = 8 << 30


def open_log(
    path: str | os.PathLike[str], *, allow_large: bool = False, components: Mapping[str, type[Component]] | None = None
) -> Log:
    """Open a log; only its index is read until data are requested.

    Args:
        path: an MCAP file written by `record`; a file of a killed writer opens up to its intact part.
        allow_large: lift the limits on sizes, for a file of trusted origin.
        components: component classes outside this package, by name; a log never loads them itself.

    Raises:
        LogError: not a log, or a damaged log.
    """
    log = Log(to_path(path), allow_large)
    log.components = components or {}
    return log


class Log(RecordReader):
    """A log returned by `open_log`: the recorded variables over time, and the steps and inputs to run it again.

    Times are those of the component. Resets and restores divide a log into several *segments*, which are concatenated:
    times continue from segment to segment, so every moment of the run has a unique time.

    Attributes:
        path, size: the file, and its size [bytes].
        complete: False if the writer was killed before it closed the file.
        identity: eight unique bytes in hex, by which a branch names its parent.
        variables: the recorded variables by name.
        input_variables: the inputs of the component by name.
        step_size: length of a tick (internal step) [s].
        start_tick, end_tick: first tick (0, or later for a branch) and last tick of the log's time, with concatenated segments.
        components: component classes outside this package, by name, for running the log again.
    """

    components: Mapping[str, type[Component]] = MappingProxyType({})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        size = f"{count_text(self.calls, 'call')}, {count_text(self.end_tick - self.start_tick, 'tick')}, {self.duration:g} s"
        return f"<Log {str(self.path)!r}: {self.header.get('component')}, {size}, {state}>"

    def _repr_html_(self) -> str:
        experiment = self.header.get("experiment")
        name = experiment.get("name") if isinstance(experiment, dict) else None
        facts = {"experiment": name, "events": int(self.rows(EVENTS)[:, COUNT].sum()), "bytes": self.size}
        rows = (
            (one.name, one.unit, one.shape, int(self.frame_rows(one.name)[:, COUNT].sum()), one.description)
            for one in self.variables.values()
        )
        return html_summary(repr(self).strip("<>"), facts, ("name", "unit", "shape", "frames", "description"), rows)

    @property
    def complete(self) -> bool:
        """Return whether the log was closed; otherwise its writer was killed."""
        return self.container.complete

    @property
    def metadata(self) -> dict[str, Any]:
        """Component, parameters, experiment, versions, machine, options, kinds of events; if closed, report and conclusions."""
        closing = self.closing.header if self.closing is not None else {}
        found = {**self.header, "complete": self.complete, "damage": self.container.damage, "report": closing.get("report")}
        found |= {name: header_table(found.get(name)) for name in ("parameters", "versions", "machine", "report")}
        for name in ("cautions", "conclusions"):
            texts = closing.get(name)
            found[name] = [str(text) for text in texts] if isinstance(texts, list) else []
        return found

    @property
    def incidents(self) -> list[dict[str, Any]]:
        """Return the incidents of the recording.

        The key "incident" holds the kind: "failed" and "interrupted" (a step was undone), "unrecorded" (steps are not in the
        log), "recovered" and "resumed" (the log was recovered or resumed).
        """
        return [dict(self.read_record(row).header) for row in self.index.select_rows(INCIDENTS, 0)]

    @property
    def segments(self) -> list[Segment]:
        """The segments that are not empty."""
        return self.index.segments

    @property
    def calls(self) -> int:
        """Number of calls of `step` in the log."""
        return int(self.rows(STEPS)[:, COUNT].sum())

    @property
    def duration(self) -> float:
        """Simulated time in the log [s]."""
        return (self.end_tick - self.start_tick) * self.step_size

    @cached_property
    def drawables(self) -> tuple[Drawable, ...]:
        """Return the drawables of the component."""
        with self.name_file_in_errors():
            return parse_drawables(self.header.get("drawables"), self.header_arrays, self.variables)

    @cached_property
    def balances(self) -> tuple[BalanceNames, ...]:
        """The names of the variables of each balance, such as of energy; all of them are recorded."""
        with self.name_file_in_errors():
            return parse_balance_names(self.header.get("balances"))

    def events(self, kind: str | None = None, index: int | None = None) -> list[Event]:
        """Return the events of the log in the order of time, in ticks of the log; see `earlier_events`.

        Args:
            kind: only events of this kind; see `event_kinds`.
            index: only events of this link, cell, ...

        Raises:
            ParameterError: an unknown kind, or an invalid index.
        """
        parts = [np.zeros((0, 5))]
        for row in self.rows(EVENTS):
            parts.append(self.event_rows(row).copy())
            parts[-1][:, 0] = self.log_tick(row[SEGMENT], parts[-1][:, 0])
        return decode_events(np.concatenate(parts), self.event_kinds, kind, index, "")

    def earlier_events(self, kind: str | None = None, index: int | None = None) -> list[Event] | None:
        """Return the events before the start of the log, such as before a branch; see `events`.

        They come from the component in the state at the log's start.

        Returns:
            None if the component cannot be built here.
        """
        refuse_unknown_events(self.event_kinds, kind, index, "")
        if self._earlier_events is None:
            return None
        return [event for event in self._earlier_events if kind in (None, event.kind) and index in (None, event.index)]

    @cached_property
    def _earlier_events(self) -> list[Event] | None:
        if self.start_tick == 0 or not self.event_kinds:
            return []
        try:
            return self.component().events()
        except GranularError:
            return None

    @property
    def event_details(self) -> dict[str, EventDetail]:
        """Details (unit, elements counted by the index) of the kinds of event that have them; see `events.EventDetail`."""
        details = self.header.get("event_details", {})
        try:
            found = {kind: EventDetail(**detail) for kind, detail in details.items()}
            if all(isinstance(text, str) for one in found.values() for text in (one.unit, one.counts, one.ratio)):
                return found
        except (AttributeError, TypeError):
            pass
        raise damage_error("the details of the kinds of events are invalid", "header.event_details", self.path)

    def ticks(self, name: str) -> np.ndarray:
        """Return the ticks, counted in the log's time, at which a variable was recorded, shape (frames,), int64."""
        parts = [self.log_tick(row[SEGMENT], self.frames(row, name)[0]) for row in self.frame_rows(name)]
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def times(self, name: str) -> np.ndarray:
        """Return the times at which a variable was recorded, shape (frames,) [s]."""
        return self.ticks(name) * self.step_size

    def series(self, name: str, segment: Segment | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return times (frames,) [s] and values (frames, ...) of a variable, optionally of one segment."""
        if not isinstance(name, str):
            raise ParameterError(f"got {one_line(name)}", expected="the name of one variable", at="name")
        rows = self.frame_rows(name)
        rows = rows if segment is None else rows[rows[:, SEGMENT] == segment.number]
        shape = self.variables[name].shape
        check_size(int(rows[:, COUNT].sum()) * 8 * int(np.prod(shape, dtype=object)), self.limits)
        parts = [(self.log_tick(row[SEGMENT], ticks), values) for row in rows for ticks, values in [self.frames(row, name)]]
        ticks = np.concatenate([np.zeros(0, np.int64), *(ticks for ticks, _ in parts)])
        return ticks * self.step_size, np.concatenate([np.zeros((0, *shape)), *(values for _, values in parts)])

    def frames_at(self, name: str, numbers: np.ndarray, elements: Sequence[int] | None = None) -> np.ndarray:
        """Return the frames with the given numbers, counted as in `times`; only the records with these frames are read.

        The shape is (numbers, *shape) or, for given elements (indices in the flat array), (numbers, elements).
        """
        rows, shape = self.frame_rows(name), self.variables[name].shape if elements is None else (len(elements),)
        begins = np.cumsum(rows[:, COUNT]) - rows[:, COUNT]
        owners = np.searchsorted(begins, numbers, side="right") - 1
        chosen = np.empty((len(numbers), *shape))
        for owner in np.unique(owners):
            here = owners == owner
            values = self.frames(rows[owner], name)[1][numbers[here] - begins[owner]]
            chosen[here] = values if elements is None else values.reshape(len(values), -1)[:, elements]
        return chosen

    def get(self, name: str, time: float) -> Any:
        """Return the last frame of a variable at or before a time [s]: a number, or an array of its shape.

        Raises:
            ParameterError: the variable was not recorded, or the time is outside the log.
        """
        tick, rows = self._tick_at(time), self.frame_rows(name)
        firsts = [self.log_tick(row[SEGMENT], row[FIRST]) for row in rows]
        place = int(np.searchsorted(firsts, tick, side="right")) - 1
        if place < 0:
            raise ParameterError(f"got {time:g} s, which is before the first frame of {name!r}", at="time")
        if tick > self.end_tick:
            raise self._outside_error(time)
        ticks, values = self.frames(rows[place], name)
        own = int(np.searchsorted(self.log_tick(rows[place][SEGMENT], ticks), tick, side="right")) - 1
        value = values[own]
        return float(value) if value.ndim == 0 else value.copy()

    def to_xarray(self) -> Any:
        """Return all frames as an `xarray.Dataset` over time, which can be drawn without this package.

        Variables over the same elements, such as grains, share a dimension, so that ``data.velocity * data.displacement`` has
        the dimensions (time, grain). Coordinates are the initial positions and radii (``grain_x``, ``grain_radius``), the
        nodes of cells (``cell_nodes``), the points of links (``link_points``), and the names of directions and of entries of
        tensors. Units and descriptions are in the attributes of the variables; experiment, parameters, step size and
        versions in those of the dataset.

        Raises:
            MissingExtraError: xarray is not installed.
            LogError: the variables were not recorded at the same times.
        """
        from .dataset import make_dataset

        return make_dataset(self)

    def export(
        self,
        to: str,
        path: str | os.PathLike[str] | None = None,
        *,
        start: float | None = None,
        end: float | None = None,
        every: float | None = None,
        variables: Sequence[str] | None = None,
        overwrite: bool = False,
        progress: Progress = False,
    ) -> Export:
        """Write frames in the format of another program; memory use does not grow with their number.

        Args:
            to: "vtk", "xyz", "csv", "netcdf" or "hdf5".
            path: the file or, for VTK, the folder; by default next to the log.
            start: time of the first frame [s].
            end: time of the last frame [s].
            every: keep the first frame of each interval of this length, counted from `start` [s]; by default all frames.
            variables: names of variables; by default all that the format can contain, and in CSV those with at most 16 values.
            overwrite: whether an existing file or folder may be replaced.
            progress: whether to show a progress bar, or a function to call with the fraction done.

        Raises:
            ParameterError: an unknown format or variable, no frame in the time range, or the path exists.
            LogError: the format does not apply, the log has no intact frame, or the path cannot be written; no file is left.
            MissingExtraError: the format needs a package that is not installed.
        """
        from .export.formats import export_log

        return export_log(self, to, path, (start, end, every), variables, overwrite, progress)

    def input_intervals(self, name: str) -> Iterator[InputInterval]:
        """Yield the intervals between changes of an input in order, each with the value or profile held in it; not sampled."""
        for segment in self.segments:
            held = self.snapshot(segment, segment.start).inputs
            shift = int(self.log_tick(segment.number, 0))
            yield from step_history.input_intervals(self.step_history(segment), held, name, segment.end, shift)

    def step_history(self, segment: Segment) -> StepHistory:
        """Return the lengths and the set inputs, bit by bit, of all calls of `step` in a segment."""
        return self._step_histories[segment.number]

    def snapshot(self, segment: Segment, tick: int) -> Snapshot:
        """Return the last snapshot of a segment at or before a tick."""
        rows = self.index.select_rows(SNAPSHOTS, None, segment.number)
        rows = rows[rows[:, FIRST] <= tick]
        if not len(rows):
            raise damage_error(f"no snapshot at or before tick {tick}", "snapshots", self.path)
        return self.read_snapshot(rows[np.argmax(rows[:, FIRST])])

    def segment_and_tick(self, time: float) -> tuple[Segment, int]:
        """Return the segment at a time [s] of the log, and the tick in it; where two segments meet, the later one."""
        tick = self._tick_at(time)
        if not self.start_tick <= tick <= self.end_tick or not self.segments:
            raise self._outside_error(time)
        segment = next(s for s in reversed(self.segments) if self.log_tick(s.number, s.start) <= tick)
        return segment, tick - self.log_tick(segment.number, 0)

    def component(self) -> Component:
        """Return a new component with the log's parameters, in the state at the log's start.

        Raises:
            LogError: the parameters do not match the identity stated in the log.
        """
        component = self.new_component()
        if component.identity != self.header.get("identity"):
            raise LogError(
                "the parameters do not match the identity stated in the log",
                hint=f"they were changed, or another version of {component.name!r} recorded the log (see `replay --verify`)",
                source=self.source,
            )
        if self.segments:
            restore_snapshot(component, self.snapshot(self.segments[0], self.segments[0].start))
        return component

    def new_component(self) -> Component:
        """Return a new component with the log's parameters after a reset; the identity in the log is not compared with it."""
        return make_component(self.header, self.limits, self.components)

    def branch(self, at: float) -> Branch:
        """Return a branch: a component in the state at a time [s] of the log, with the log's inputs from there on.

        A time between two steps is rounded to the nearest step; ``.component.time`` is the time used.

        Raises:
            ParameterError: the time is outside the log.
            LogError: the log cannot be run again.
        """
        try:
            return make_branch(self, at)
        except ParameterError as error:
            raise error.with_argument("time", "at") from None

    def _outside_error(self, time: float) -> ParameterError:
        first, last = self.start_tick * self.step_size, self.end_tick * self.step_size
        return ParameterError(f"got {time:.12g} s, but the log extends from {first:.12g} s to {last:.12g} s", at="time")

    def _tick_at(self, time: float) -> int:
        try:
            return round(float(time) / self.step_size)
        except (TypeError, ValueError, OverflowError) as error:
            raise ParameterError(f"got {time!r}", expected="seconds", at="time") from error

    @cached_property
    def _step_histories(self) -> dict[int, StepHistory]:
        """Return the calls of `step` of each segment."""
        check_size(int(self.index.select_rows(STEPS)[:, COUNT].sum()) * 16, self.limits)
        shapes = {name: variable.shape for name, variable in self.input_variables.items()}
        profiles: list[CompiledProfile] = []
        found = {}
        for segment in self.index.all_segments:
            own = [self.read_record(row) for row in self.index.select_rows(STEPS, None, segment.number)]
            with self.name_file_in_errors():
                found[segment.number] = step_history.parse_steps(own, segment.start, shapes, profiles, self.step_size)
        return found


def check_size(size: int, limits: Limits) -> None:
    """Raise an error if arrays to be read have more bytes than the limit, because an untrusted log may state any size."""
    limits.check("the size of the requested data, in bytes,", size, _MOST_BYTES)
    refuse_excess_memory(size, f"{limits.source}: the requested data", LogError)
