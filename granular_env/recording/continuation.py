"""The continuation of a log whose run ended too early, from where it ends, bit for bit.

Every record up to the last steps is kept as it is; the ticks after the last snapshot are run again and compared with the log.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from ..components.component import Component
from ..components.errors import LogError
from ..components.inputs import Held
from .header import versions
from .index import FIRST, KIND, LAST
from .log import Log
from .recorder import Kept, Recorder, begin_log
from .records import INCIDENTS, SNAPSHOTS, STEPS, Record
from .recovery import copy_records, preview_of
from .rerun import check_work
from .schedule import schedule_from
from .verification import Comparison, Difference, Verification
from .writer import LogWriter


@dataclass(slots=True)
class Continuation:
    """A log of one segment, cut after its last steps.

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

    def recorder(self, path: str | os.PathLike[str], overwrite: bool) -> Recorder:
        """Return a recorder of the component that continues the log in a new file.

        Raises:
            ParameterError: the file exists, and may not be replaced.
            LogError: it cannot be written.
        """
        log, component, header = self.log, self.component, self.log.header
        schedule, names = schedule_from(header.get("options")), list(log.variables)
        writer = LogWriter(path, overwrite)
        if not self.kept:
            facts = header.get("experiment"), header.get("parent"), log.elapsed
            return begin_log(component, writer, names, schedule, *facts)
        try:
            copy_records(log, writer, self.kept)
            tick = component.tick
            facts = {"incident": "resumed", "versions": versions()}
            resumed = Record(INCIDENTS, 0, 0, tick, tick, 1, writer.number(INCIDENTS), facts, {})
            writer.add(resumed, log.nanoseconds(tick))
            writer.flush()
            preview = preview_of(log, tick)
        except BaseException:
            writer.abandon()
            raise
        kept = Kept(log.start_tick, self.key, self._profiles())
        return Recorder(component, writer, names, schedule, preview, log.elapsed, kept)

    def _profiles(self) -> int:
        """Return the number of compiled profiles that stay."""
        rows = self.log.index.rows[: self.kept]
        return sum(len(self.log.read(row).arrays["profile_shapes"]) for row in rows[rows[:, KIND] == STEPS])


def continuation_of(log: Log) -> Continuation:
    """Return a log, cut where it is certain, and its component there, run again from the last snapshot before that.

    Raises:
        LogError: it holds several histories; it cannot be run again, or gives other bits now.
    """
    where, segments = log.source, log.index.all_segments
    if len(segments) > 1:
        came = f"its component was reset or put back {len(segments) - 1} times on the way"
        raise LogError(came, hint="branch off it instead: granular-env branch", source=where)
    recovered = any(incident.get("incident") == "recovered" for incident in log.incidents)
    closed = log.closing is not None and not recovered
    component, steps = log.component(), np.flatnonzero(log.index.rows[:, KIND] == STEPS)
    kept = int(steps[-1]) + 1 if len(steps) else 0
    rows = log.index.rows[:kept]
    found = Continuation(log, component, {}, kept, log.start_tick, closed)
    tick = int(rows[-1, LAST]) if kept else log.start_tick
    if kept:
        keys = rows[rows[:, KIND] == SNAPSHOTS]
        snapshot = log.snapshot_in(keys[np.argmax(keys[:, FIRST])])
        found.key = snapshot.tick
        check_work(tick - snapshot.tick, component, log.limits)
        try:
            Comparison(log, component, segments[0], Verification(str(log.path), log.complete)).run(snapshot, tick)
        except Difference as error:
            time = f"{error.tick * log.step_size:.9g} s"
            came = f"run again, it gives another {error.variable} at {time}: it was changed, or another version recorded it"
            raise LogError(came, hint="run the experiment again", source=where) from error
    held = log.snapshot(segments[0], log.start_tick).inputs
    found.changes = {at: inputs for at, inputs in log.steps_of(segments[0]).changes(held) if at >= tick}
    return found
