"""Recovery of an unclosed or damaged log, and bitwise continuation from its end.

For a continuation, all records up to the last steps are kept unchanged. The ticks after the last snapshot are run again and
compared with the log.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from ..components.component import Component
from ..components.errors import LogError, ParameterError
from ..components.inputs import Held
from .batches import Place
from .header import balance_quantities, header_title, versions
from .index import FIRST, KIND, LAST, SEGMENT, all_records
from .log import Log, open_log
from .preview.film import Preview
from .recorder import Recorder
from .records import CLOSED, HEADER, INCIDENTS, SNAPSHOTS, STEPS, Record
from .replay import check_work
from .schedule import parse_schedule
from .verification import Comparison, Difference, Verification
from .writer import LogWriter, to_path


def recover(
    path: str | os.PathLike[str], out: str | os.PathLike[str], *, allow_large: bool = False, overwrite: bool = False
) -> Log:
    """Write a complete log with the intact part of `path`, from the front to the first damage.

    Args:
        path: the log of a killed process, or a damaged log; it is only read.
        out: the new file.
        allow_large: lift the limits on sizes.
        overwrite: whether an existing `out` may be replaced.

    Returns:
        The new log, opened; the last of ``.incidents`` describes the loss.

    Raises:
        LogError: nothing is intact, or `out` cannot be written; no file is left.
        ParameterError: `out` exists, or is not a replaceable log, or is the damaged file.
    """
    source, target = to_path(path), to_path(out)
    with Log(source, allow_large, scan=True) as log:
        if os.path.exists(target) and os.path.samefile(source, target):
            raise ParameterError("this file is the damaged log", hint="choose another name", source=f"log {str(target)!r}")
        writer = LogWriter(target, overwrite, is_hidden=True)
        try:
            copy_records(log, writer, len(log.index.rows))
            writer.add_preview(make_preview(log).messages())
            # The report and the cautions are in the closing record only, so they are lost without it.
            facts = dict(log.closing.header) if log.closing is not None else {}
            lost = "nothing of the run" if log.closing is not None else "what had not been written when the process ended"
            lost, bytes_lost = log.container.damage or lost, log.container.bytes_lost
            told = {"incident": "recovered", "from": source.name, "lost": lost, "bytes_lost": bytes_lost}
            number, tick = next(((one.number, one.end) for one in reversed(log.index.all_segments)), (0, 0))
            writer.add_record(Record(INCIDENTS, 0, number, tick, tick, 1, 0, told, {}), log.nanoseconds(log.end_tick))
            writer.finish(number, tick, log.nanoseconds(log.end_tick), facts)
        finally:
            writer.abandon()
    return open_log(target, allow_large=allow_large)


def copy_records(log: Log, writer: LogWriter, count: int) -> None:
    """Write the first `count` records of a log unchanged, but leave out its closing record."""
    with log.name_file_in_errors():
        for _, time, record in islice(all_records(log.container), count):
            if record.kind == HEADER:
                writer.add_header(record)
            elif (record.kind, record.detail) != (INCIDENTS, CLOSED):
                writer.add_record(record, time)


def make_preview(log: Log, end: int | None = None) -> Preview:
    """Return the preview made from the frames of a log up to the tick `end` of the log's time; default: all frames."""
    quantities = balance_quantities(log.header.get("balances"))
    preview = Preview(header_title(log.header), log.drawables, log.variables, quantities)
    for together in zip(*(_log_frames(log, name) for name in log.variables), strict=False):
        tick = together[0][0]
        if end is None or tick <= end:
            values = [value for _, value in together]
            preview.add_frame(log.nanoseconds(tick), dict(zip(log.variables, values, strict=True)))
    return preview


def _log_frames(log: Log, name: str) -> Iterator[tuple[int, Any]]:
    """Yield, for each frame of a variable, its tick in the log's time and its value."""
    for row in log.frame_rows(name):
        ticks, values = log.frames(row, name)
        yield from zip(log.log_tick(row[SEGMENT], ticks).tolist(), values, strict=True)


@dataclass(slots=True)
class Continuation:
    """A log with one segment, cut off after the last record of steps, and its component there, ready to run on.

    Attributes:
        log: the original log.
        component: the component in its state at the last kept tick.
        changes: mapping from tick to the inputs that the log sets there, from the component's tick on.
        kept: number of kept records, from the front; the last contains steps.
        key: tick of the last kept snapshot.
        closed: whether the log was closed, so that nothing was dropped.
    """

    log: Log
    component: Component
    changes: dict[int, dict[str, Held]]
    kept: int
    key: int
    closed: bool

    def make_recorder(self, path: str | os.PathLike[str], overwrite: bool) -> Recorder:
        """Return a recorder of the component that continues the log in a new file.

        Raises:
            ParameterError: the file exists and may not be replaced.
            LogError: the file cannot be written.
        """
        log, component, schedule = self.log, self.component, parse_schedule(self.log.header.get("options"))
        writer, tick = LogWriter(path, overwrite), component.tick
        try:
            copy_records(log, writer, self.kept)
            facts = {"incident": "resumed", "versions": versions()}
            writer.add_record(Record(INCIDENTS, 0, 0, tick, tick, 1, 0, facts, {}), log.nanoseconds(tick))
            writer.flush()
            preview = make_preview(log, tick)
        except BaseException:
            writer.abandon()
            raise
        steps = log.read_record(log.index.rows[self.kept - 1])
        profiles = steps.header["profiles_before"] + len(steps.arrays["profile_shapes"])
        place = Place(0, log.start_tick, log.elapsed)
        return Recorder(component, writer, list(log.variables), schedule, preview, place, profiles, self.key)


def make_continuation(log: Log) -> Continuation:
    """Return the continuation of a log: the log up to its last steps, and the component there, run from the last snapshot.

    Raises:
        LogError: the log has several segments, cannot be run again, or gives different bits.
    """
    rows, (segment, *others) = log.index.rows, log.index.all_segments
    if others:
        came = f"its component was reset or restored {len(others)} times during the run"
        raise LogError(came, hint="start a branch from it instead: granular-env branch", source=log.source)
    recovered = any(incident.get("incident") == "recovered" for incident in log.incidents)
    kept = int(np.flatnonzero(rows[:, KIND] == STEPS)[-1]) + 1
    keys, tick = rows[:kept][rows[:kept, KIND] == SNAPSHOTS], int(rows[kept - 1, LAST])
    component, snapshot = log.component(), log.read_snapshot(keys[np.argmax(keys[:, FIRST])])
    check_work(tick - snapshot.tick, component, log.limits)
    try:
        Comparison(log, component, segment, Verification(str(log.path), log.complete)).run(snapshot, tick)
    except Difference as error:
        time = f"{error.tick * log.step_size:.9g} s"
        came = f"the re-run gives a different {error.variable} at {time}: the log was changed, or another version recorded it"
        raise LogError(came, hint="run the experiment again", source=log.source) from error
    held = log.snapshot(segment, log.start_tick).inputs
    changes = {at: inputs for at, inputs in log.step_history(segment).input_changes(held) if at >= tick}
    return Continuation(log, component, changes, kept, snapshot.tick, log.closing is not None and not recovered)
