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
from .recorder import Kept, Recorder
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
        kept: how many records stay, from the front; the last holds steps.
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
        log, component = self.log, self.component
        writer, tick = LogWriter(path, overwrite), component.tick
        try:
            copy_records(log, writer, self.kept)
            facts = {"incident": "resumed", "versions": versions()}
            writer.add(Record(INCIDENTS, 0, 0, tick, tick, 1, 0, facts, {}), log.nanoseconds(tick))
            writer.flush()
            preview = preview_of(log, tick)
        except BaseException:
            writer.abandon()
            raise
        schedule = schedule_from(log.header.get("options"))
        steps = log.read(log.index.rows[self.kept - 1])
        kept = Kept(log.start_tick, self.key, steps.header["profiles_before"] + len(steps.arrays["profile_shapes"]))
        return Recorder(component, writer, list(log.variables), schedule, preview, log.elapsed, kept)


def continuation_of(log: Log) -> Continuation:
    """Return a log that holds steps, cut after the last of these, and its component there, run again from a snapshot.

    Raises:
        LogError: it holds several histories; it cannot be run again, or gives other bits now.
    """
    rows, (segment, *others) = log.index.rows, log.index.all_segments
    if others:
        came = f"its component was reset or put back {len(others)} times on the way"
        raise LogError(came, hint="branch off it instead: granular-env branch", source=log.source)
    recovered = any(incident.get("incident") == "recovered" for incident in log.incidents)
    kept = int(np.flatnonzero(rows[:, KIND] == STEPS)[-1]) + 1
    keys, tick = rows[:kept][rows[:kept, KIND] == SNAPSHOTS], int(rows[kept - 1, LAST])
    component, snapshot = log.component(), log.snapshot_in(keys[np.argmax(keys[:, FIRST])])
    check_work(tick - snapshot.tick, component, log.limits)
    try:
        Comparison(log, component, segment, Verification(str(log.path), log.complete)).run(snapshot, tick)
    except Difference as error:
        time = f"{error.tick * log.step_size:.9g} s"
        came = f"run again, it gives another {error.variable} at {time}: it was changed, or another version recorded it"
        raise LogError(came, hint="run the experiment again", source=log.source) from error
    held = log.snapshot(segment, log.start_tick).inputs
    changes = {at: inputs for at, inputs in log.steps_of(segment).changes(held) if at >= tick}
    return Continuation(log, component, changes, kept, snapshot.tick, log.closing is not None and not recovered)
