"""A log whose run ended too early, and the component where the log leaves it: the run goes on from there, bit for bit.

What a killed process wrote last may be half of a batch: its steps without all of their frames. So the last batch is left out,
and made again. Of the rest every record is kept as it is; the ticks after the last snapshot are run again and compared with it.
"""

from __future__ import annotations

import heapq
import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.errors import LogError
from ...components.inputs import Held
from ..format.digests import hash_row
from ..format.header import versions
from ..format.metadata import metadata_of_log
from ..format.record_index import COUNT, DETAIL, FIRST, KIND, LAST
from ..format.records import END, EVENTS, FRAMES, HASHES, HEADER, INCIDENTS, SNAPSHOTS, STEPS, TOPICS, Record, decode, words
from ..preview.frame_selection import PreviewFrames
from ..recorder.log_file import create
from ..recorder.log_writer import LogWriter, as_path
from ..recorder.recorder import Recorder
from ..recorder.sampling import schedule_from
from .log import Log
from .preview_reconstruction import preview_of_every
from .steps import advance, check_work, restore


@dataclass(slots=True)
class Continuation:
    """A log of one segment, cut at the end of a batch.

    Attributes:
        log: as it was left.
        component: at the last tick that is kept.
        changes: inputs to set from there on, by tick.
        kept: how many records stay, from the front; with none the run is recorded from its start.
        key: tick of the last snapshot that stays.
        closed: whether the log was closed, so that nothing of it had to be left out.
    """

    log: Log
    component: Component
    changes: dict[int, dict[str, Held]]
    kept: int
    key: int
    closed: bool

    @property
    def start(self) -> int:
        """Tick at which the log begins."""
        return self.log.start_tick

    @property
    def frames(self) -> int:
        """Number of frames that stay."""
        rows = self._rows(FRAMES)
        return int(rows[rows[:, DETAIL] == 0, COUNT].sum())

    @property
    def profiles(self) -> int:
        """Number of compiled profiles that stay."""
        steps = (self.log.records.read(row) for row in self._rows(STEPS))
        return sum(len(record.arrays["profile_shapes"]) for record in steps)

    def preview(self) -> PreviewFrames:
        """Return the preview of the frames that stay."""
        return preview_of_every(self.log, self.frames)

    def copy_to(self, sink: LogWriter) -> None:
        """Write the records that stay, and that the run goes on."""
        log = self.log
        for message in self._messages():
            record = decode(message.data, TOPICS[message.topic], sink.log or None, log.records.container.most_text)
            sink.add(record, message.nanoseconds)
            if record.kind == HEADER:
                sink.flush()
                sink.add_metadata(metadata_of_log(log.records.header, self.component.Parameters))
        tick = self.component.tick
        content = {"incident": "resumed", "versions": versions()}
        place = 0, tick, tick, 1, sink.number(INCIDENTS)
        sink.add(Record(INCIDENTS, 0, *place, content, {}), log.records.nanoseconds(tick))
        sink.flush()

    def recorder(self, path: str | os.PathLike[str], overwrite: bool) -> Recorder:
        """Return a recorder of the component that goes on with the log, in a file of its own.

        Raises:
            ParameterError: the file exists, and may not be replaced.
            LogError: it cannot be written.
        """
        log, target = self.log, as_path(path)
        schedule, file = schedule_from(log.records.header.get("options")), create(target, overwrite)
        facts = log.records.header.get("experiment"), log.records.header.get("parent"), log.records.elapsed
        return Recorder(self.component, target, file, list(log.variables), schedule, *facts, self if self.kept else None)

    def _messages(self) -> Iterator[Any]:
        own = (message for _, message in self.log.records.container.all_messages() if message.topic in TOPICS)
        return itertools.islice(own, self.kept)

    def _rows(self, kind: int) -> np.ndarray:
        rows = self.log.records.index.rows[: self.kept]
        return rows[rows[:, KIND] == kind]


def continuation_of(log: Log) -> Continuation:
    """Return a log, cut where it is certain, and its component there, run again from the last snapshot before that.

    Raises:
        LogError: it holds several histories; it cannot be run again, or gives other bits now.
    """
    where = f"log {str(log.path)!r}"
    if len(log.records.index.all_segments) > 1:
        came = f"its component was reset or put back {len(log.records.index.all_segments) - 1} times on the way"
        raise LogError(came, hint="branch off it instead: granular-env branch", source=where)
    closed = log.records.closing is not None and "recovered" not in _incidents(log)
    kept = _kept_records(log, closed)
    component = log.component()
    found = Continuation(log, component, {}, kept, log.start_tick, closed)
    tick = int(found._rows(STEPS)[-1, LAST]) if kept else log.start_tick
    began = component.event_count
    _run_again(found, tick)
    held = log.snapshot(log.segments[0], log.start_tick).inputs
    found.changes = {at: inputs for at, inputs in log.steps_of(log.segments[0]).changes(held) if at >= tick}
    if kept and component.event_count - began != int(found._rows(EVENTS)[:, COUNT].sum()):
        raise _differs(log, "events", tick)
    return found


def _incidents(log: Log) -> list[Any]:
    return [incident.get("incident") for incident in log.incidents]


def _kept_records(log: Log, closed: bool) -> int:
    """Return how many records stay: all up to the end of a run that was closed, else all before the last batch."""
    rows = log.records.index.rows
    if closed:
        ends = (rows[:, KIND] == SNAPSHOTS) & (rows[:, DETAIL] == END)
        return int(np.flatnonzero(ends)[0]) if ends.any() else len(rows) - 1
    batches = np.flatnonzero(rows[:, KIND] == STEPS)
    # With the first batch go the digests of parameters and header: then nothing is kept.
    return int(batches[-1]) if len(batches) > 1 else 0


def _run_again(found: Continuation, tick: int) -> None:
    """Bring the component from the last snapshot to the end of what is kept, and compare what that gives with the log."""
    log, component, rows = found.log, found.component, found._rows(SNAPSHOTS)
    if not found.kept:
        return
    snapshot = log.records.snapshot(rows[np.argmax(rows[:, FIRST])])
    found.key = snapshot.tick
    check_work(tick - snapshot.tick, component, log.records.limits)
    start = log.snapshot(log.segments[0], log.start_tick)
    changes = [change for change in log.steps_of(log.segments[0]).changes(start.inputs) if change[0] >= snapshot.tick]
    changes.reverse()
    restore(component, snapshot)
    for at, name, recorded in heapq.merge(*_marks(found, snapshot.tick), key=itemgetter(0)):
        advance(component, changes, at)
        if words(_value(component, name, list(log.input_variables))) != words(recorded):
            raise _differs(log, name or "state", at)
    advance(component, changes, tick)


def _marks(found: Continuation, after: int) -> list[Iterator[tuple[int, str, np.ndarray]]]:
    """Return what was recorded after a tick, for each variable, and for the hashes: tick, name or "", and that."""
    frames, hashes = found._rows(FRAMES), found._rows(HASHES)
    marks = [
        _frame_marks(found.log, frames[(frames[:, DETAIL] == number) & (frames[:, LAST] > after)], name, after)
        for number, name in enumerate(found.log.variables)
    ]
    return [*marks, _hash_marks(found.log, hashes[(hashes[:, DETAIL] == 0) & (hashes[:, LAST] > after)], after)]


def _frame_marks(log: Log, rows: np.ndarray, name: str, after: int) -> Iterator[tuple[int, str, np.ndarray]]:
    for row in rows:
        ticks, values = log.records.frames(row, name)
        yield from ((at, name, value) for at, value in zip(ticks.tolist(), values, strict=True) if at > after)


def _hash_marks(log: Log, rows: np.ndarray, after: int) -> Iterator[tuple[int, str, np.ndarray]]:
    for row in rows:
        arrays = log.records.read(row).arrays
        yield from ((at, "", own) for at, own in zip(arrays["ticks"].tolist(), arrays["rows"], strict=True) if at > after)


def _value(component: Component, name: str, inputs: list[str]) -> np.ndarray:
    """Return what a frame of a variable, or under "" a row of hashes, holds now."""
    if not name:
        return hash_row(component, [variable.name for variable in component.variables.values() if variable.state], inputs)
    balances = component.balance_values() if name in component.balance_names else {}
    return np.asarray(balances[name] if balances else component.peek(name), dtype=np.float64)


def _differs(log: Log, name: str, tick: int) -> LogError:
    time = f"{tick * log.step_size:.9g} s"
    came = f"run again, it gives another {name} at {time}: it was changed, or another version of the program recorded it"
    return LogError(came, hint="run the experiment anew", source=f"log {str(log.path)!r}")


__all__ = ["Continuation", "continuation_of"]
