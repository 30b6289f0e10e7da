"""Re-run a log and compare what it holds, bit for bit: frames, hashes, snapshots, inputs, declarations, report, preview."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping
from operator import itemgetter
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.errors import LogError, StepError
from ...components.snapshot import Snapshot
from ...output_files import count_of
from ...progress import Bar, Progress, progress_bar
from ..format.digests import hash_row, held_word
from ..format.record_index import DETAIL, FIRST, LAST, Segment
from ..format.records import EVENTS, FRAMES, HASHES, SNAPSHOTS, START, damage, words
from ..replay.log import Log, open_log
from ..replay.preview_reconstruction import PreviewBuilder
from ..replay.steps import Changes, advance, check_work, restore
from .changed_content import changed_header, changed_input, changed_parameters
from .declaration_comparison import closing_differences, declaration_differences, metadata_differences
from .result import Difference, Verification, foreign_facts

# What differs, the ticks of the log between which that arose, why (if known), which element.
_Found = tuple[str, tuple[int, int], str, int | None]


def verify(
    path: str | os.PathLike[str] | Log,
    *,
    progress: Progress = False,
    allow_large: bool = False,
    components: Mapping[str, type[Component]] | None = None,
) -> Verification:
    """Re-run a log from its parameters, start states and inputs, and compare all that it holds, bit for bit.

    What no re-run gives, such as the experiment or the date, is compared with digests that the log keeps of it elsewhere.

    Args:
        path: the log.
        progress: show a bar, or call this now and then with the part that is done.
        allow_large: lift the limits on sizes.
        components: classes of components that are not ours, by name; an open log has its own.

    Raises:
        LogError: the file is no log, or it is damaged, or it cannot be re-run at all. A log that can be re-run but gives
            other bits is no error: the result names the first variable and the interval.
    """
    log = path if isinstance(path, Log) else open_log(path, allow_large=allow_large, components=components)
    try:
        with progress_bar(f"verification of {log.path.name}", show=progress) as bar:
            return _Replay(log, bar).run()
    finally:
        if log is not path:
            log.close()


class _Replay:
    def __init__(self, log: Log, bar: Bar) -> None:
        self.log, self._bar = log, bar
        self.component = log.rebuilt()
        self._trusted = self.component.identity == log.records.header.get("identity")
        self._total = max(log.end_tick - log.start_tick, 1)
        self._agreed: dict[str, int] = {}
        self._balances: tuple[int, dict[str, Any]] = (-1, {})
        # Events of the component when the segment began, and those of the segment that have been compared.
        self._events_before = self._events_seen = 0
        self._segment: Segment | None = None
        self._framed = -1
        self._preview = PreviewBuilder(log, self.component)
        self.result = Verification(str(log.path), log.complete)
        for incident in log.incidents:
            self.result.incidents.append(str(incident.get("incident")))
            if incident.get("incident") == "unrecorded":
                self.result.gaps.append(str(incident.get("message"))[:400])

    def run(self) -> Verification:
        log, result = self.log, self.result
        check_work(log.end_tick - log.start_tick, self.component, log.records.limits)
        parameters, why_not = changed_parameters(log, self.component), ""
        changed, found = None, None
        try:
            self._check_header()
            changed = changed_input(log)
            found = self._first_difference()
        except LogError as error:
            # A changed parameter is what people have to hear of, also where nothing can be re-run with it.
            if not parameters:
                raise
            why_not = str(error)
        self._name_causes(parameters, changed, found)
        if not parameters:
            self._compare_the_rest(found is None)
        if not self._trusted:
            self._explain_identity()
        result.notes += [f"it cannot be re-run with them: {why_not}"] if why_not else []
        result.notes += foreign_facts(log.records.header) if result.variable is not None else []
        return result

    def _first_difference(self) -> _Found | None:
        # Also segments in which nothing happened: they hold a state, and perhaps a frame.
        for segment in self.log.records.index.all_segments:
            try:
                self._run_segment(segment)
            except Difference as found:
                before = self._agreed.get(found.variable, segment.start)
                first, last = (self.log.records.log_tick(segment.number, tick) for tick in (before, found.tick))
                return found.variable, (first, last), found.reason, found.index
            self.result.calls += len(self.log.steps_of(segment))
            self.result.ticks += segment.end - segment.start
        return None

    def _name_causes(self, parameters: list[str], changed: Any, found: _Found | None) -> None:
        """Name what was changed, in the interval where that shows, before its consequences."""
        whole = self.log.start_tick, self.log.end_tick
        for name in parameters:
            # Where it shows at once, as in the energy of the start, nothing is narrowed down.
            span = found[1] if found and found[1][0] < found[1][1] else whole
            self._differs(name, span, "this parameter is not what was recorded", None)
        if changed is not None:
            name, (first, last), reason = changed
            if found is None or found[1][1] > first:
                if found is not None and found[1][0] < last:
                    first, last = max(first, found[1][0]), min(last, found[1][1])
                self._differs(name, (first, last), reason, None)
                changed = None
        if found is not None:
            self._differs(*found)
        if changed is not None:
            self._differs(changed[0], changed[1], changed[2], None)

    def _compare_the_rest(self, ran_through: bool) -> None:
        """Compare what has no time of its own; what follows from the run only where that agreed."""
        log, component, result = self.log, self.component, self.result
        for name in changed_header(log):
            self._add(name, f"{name} of the header is not what was recorded: it does not match its digest")
        for name, reason in (*declaration_differences(log, component), *metadata_differences(log, component)):
            self._add(name, reason)
        if not ran_through:
            return
        for name, reason in closing_differences(log, component):
            self._add(name, reason)
        result.missing += [f"the {name}" for name in ("report", "cautions") if name not in log.records.closing_header]
        result.missing += [self._preview.missing] if self._preview.missing else []
        if not self._preview.missing and (reason := self._preview.difference()):
            self._add("preview", f"the preview for other viewers differs: {reason}")

    def _explain_identity(self) -> None:
        claim = "the log's parameters do not give the identity that it or its snapshots claim"
        self._add("identity", f"{claim}: they were changed, or the program was")

    # -- one segment ------------------------------------------------------------------------------------------------

    def _run_segment(self, segment: Segment) -> None:
        self._segment, self._framed = segment, -1
        component, start = self.component, self.log.snapshot(segment, segment.start)
        restore(component, self._adopt(start))
        self._agreed, self._balances = {}, (-1, {})
        self._events_before, self._events_seen = component.event_count, 0
        self._check_earlier_events(segment)
        changes = self.log.steps_of(segment).changes(start.inputs)
        changes.reverse()
        for tick, check, *facts in heapq.merge(*self._marks(segment), key=itemgetter(0)):
            self._advance(changes, tick)
            check(tick, *facts)
        self._advance(changes, segment.end)
        self._refuse_missing_events(segment)

    def _check_earlier_events(self, segment: Segment) -> None:
        row = self.log.records.index.select(SNAPSHOTS, START, segment.number)[0]
        rows = self.log.records.earlier_event_rows(row)
        if rows is not None and words(rows) != words(self.component.event_rows()):
            reason = "the events before the start are not those that its snapshot holds"
            raise Difference("events", segment.start, None, reason)

    def _refuse_missing_events(self, segment: Segment) -> None:
        """Tell of the events that the log does not hold: those after what was written last are lost, not different."""
        known = self._events_before + self._events_seen
        if self.component.event_count == known:
            return
        rows = self.component.event_rows(known)
        is_last = segment.number == self.log.records.index.all_segments[-1].number
        first = int(self.log.records.log_tick(segment.number, int(rows[0, 0])))
        if not is_last or first <= self.log.events_end_tick:
            raise Difference("events", segment.end, None, "the re-run has events that the log does not hold")
        self.result.missing.append(f"{count_of(len(rows), 'event')} from {first * self.log.step_size:.9g} s on")

    def _advance(self, changes: Changes, tick: int) -> None:
        try:
            advance(self.component, changes, tick, self._tell)
        except StepError as error:
            at = round(error.time / self.component.step_size)
            raise Difference(
                error.variable, at, error.index, f"the re-run broke down where the log went on: {error}"
            ) from error

    def _tell(self) -> None:
        if self._bar.is_due() and self._segment is not None:
            done = self.result.ticks + self.component.tick - self._segment.start
            self._bar.update(min(done / self._total, 1.0))

    def _marks(self, segment: Segment) -> list[Iterator[tuple[Any, ...]]]:
        rows = self.log.records.index.select(FRAMES, None, segment.number)
        found = [self._frame_marks(rows[rows[:, DETAIL] == n], name) for n, name in enumerate(self.log.variables)]
        # At the same tick the inputs come first: a difference in them is the cause, one in the state what came of it.
        held, hashed = (self._hash_marks(segment, check) for check in (self._check_held, self._check_hash))
        return [held, *found, self._event_marks(segment), hashed, self._snapshot_marks(segment)]

    def _frame_marks(self, rows: np.ndarray, name: str) -> Iterator[tuple[Any, ...]]:
        for row in rows:
            ticks, values = self.log.records.frames(row, name)
            for tick, value in zip(ticks.tolist(), values, strict=True):
                yield tick, self._check_frame, name, value

    def _hash_marks(self, segment: Segment, check: Callable[..., None]) -> Iterator[tuple[Any, ...]]:
        for row in self.log.records.index.select(HASHES, 0, segment.number):
            record = self.log.records.read(row)
            ticks, rows = record.arrays.get("ticks"), record.arrays.get("rows")
            width = len(self._names_to_hash())
            if ticks is None or rows is None or rows.shape != (record.count, width) or ticks.shape != (record.count,):
                raise damage("a record has the wrong form", "hashes", self.log.path)
            if rows.dtype != np.int64 or ticks.dtype != np.int64 or (np.diff(ticks) <= 0).any() or ticks[0] < row[FIRST]:
                raise damage("a record has the wrong form", "hashes", self.log.path)
            for tick, own in zip(ticks.tolist(), rows, strict=True):
                yield tick, check, own

    def _event_marks(self, segment: Segment) -> Iterator[tuple[Any, ...]]:
        for row in self.log.records.index.select(EVENTS, None, segment.number):
            yield int(row[LAST]), self._check_events, self.log.records.event_rows(row)

    def _snapshot_marks(self, segment: Segment) -> Iterator[tuple[Any, ...]]:
        for row in self.log.records.index.select(SNAPSHOTS, None, segment.number):
            yield int(row[FIRST]), self._check_snapshot, row

    # -- comparing --------------------------------------------------------------------------------------------------

    def _check_frame(self, tick: int, name: str, value: np.ndarray) -> None:
        if tick != self._framed:
            self._framed = tick
            self.result.frames += 1
            assert self._segment is not None
            self._preview.take(self.component, self._balances_now(), self.log.records.log_tick(self._segment.number, tick))
        if words(np.asarray(self._value(name), dtype=np.float64)) != words(value):
            own = np.atleast_1d(np.asarray(self._value(name), dtype=np.float64)).view(np.int64).ravel()
            index = (
                int(np.argmax(own != np.atleast_1d(np.ascontiguousarray(value)).view(np.int64).ravel())) if value.ndim else None
            )
            raise Difference(name, tick, index, self._start_reason(tick))
        self._agreed[name] = tick

    def _check_held(self, tick: int, row: np.ndarray) -> None:
        names = list(self.log.input_variables)
        for name, word in zip(names, row.tolist()[-len(names) :] if names else [], strict=True):
            if held_word(self.component.held_inputs[name]) != word:
                raise Difference(name, tick, None, self._start_reason(tick))
            self._agreed[name] = tick

    def _check_hash(self, tick: int, row: np.ndarray) -> None:
        own = hash_row(self.component, self._state(), list(self.log.input_variables))
        for name, here, there in zip(self._names_to_hash(), own.tolist(), row.tolist(), strict=True):
            if here != there:
                raise Difference(name, tick, None, self._start_reason(tick))
            self._agreed[name] = tick
        self.result.hashes += 1

    def _check_events(self, tick: int, rows: np.ndarray) -> None:
        mine = self.component.event_rows(self._events_before + self._events_seen)[: len(rows)]
        if words(mine) != words(rows):
            same = [words(own) == words(row) for own, row in zip(mine, rows, strict=False)]
            place = same.index(False) if False in same else len(same)
            self._agreed["events"] = int(rows[place - 1, 0]) if place else self._agreed.get("events", 0)
            raise Difference("events", int(rows[place, 0]), None, self._start_reason(tick))
        self._events_seen += len(rows)
        self._agreed["events"] = tick

    def _check_snapshot(self, tick: int, row: np.ndarray) -> None:
        snapshot = self._adopt(self.log.records.snapshot(row))
        mine = self.component.save()
        reason = f"the snapshot at {tick * self.log.step_size:.12g} s does not hold what the re-run gives"
        for name, value in mine.inputs.items():
            if name not in snapshot.inputs or held_word(snapshot.inputs[name]) != held_word(value):
                raise Difference(name, tick, None, reason)
        if words(snapshot.memory) != words(mine.memory):
            raise Difference(self._culprit(snapshot), tick, None, reason)
        self._agreed["state"] = tick
        self.result.snapshots += 1

    def _culprit(self, snapshot: Snapshot) -> str:
        """Return which state variable a differing snapshot differs in."""
        mine = {name: words(self.component.get(name)) for name in self._state()}
        restore(self.component, snapshot)
        return next((name for name, bits in mine.items() if words(self.component.get(name)) != bits), "state")

    def _start_reason(self, tick: int) -> str:
        """Return what a difference at the start of a segment means: nothing has been run yet."""
        if self._segment is None or tick != self._segment.start:
            return ""
        return "nothing has been run yet, so the start state is not what was recorded, or this value is not"

    def _value(self, name: str) -> Any:
        return self._balances_now()[name] if name in self.component.balance_names else self.component.get(name)

    def _balances_now(self) -> dict[str, Any]:
        if self._balances[0] != self.component.tick:
            self._balances = self.component.tick, self.component.balance_values()
        return self._balances[1]

    def _adopt(self, snapshot: Snapshot) -> Snapshot:
        """With changed parameters, go on all the same: the first difference is what people want to know."""
        if snapshot.identity != self.log.records.header.get("identity"):
            self._trusted = False
        snapshot.identity = self.component.identity
        return snapshot

    def _state(self) -> list[str]:
        return [v.name for v in self.component.variables.values() if v.state]

    def _names_to_hash(self) -> list[str]:
        return [*self._state(), "state", *self.log.input_variables]

    # -- what the header says -----------------------------------------------------------------------------------------------

    def _check_header(self) -> None:
        log, component = self.log, self.component
        for name, variable in log.variables.items():
            mine = component.variables.get(name)
            if mine is None or mine.shape != variable.shape or mine.causality != variable.causality:
                raise LogError(
                    f"this program's {component.name!r} has no {name!r} of shape {variable.shape}",
                    at="header.variables",
                    source=f"log {str(log.path)!r}",
                )
        known = [v.name for v in component.variables.values() if v.causality == "input"]
        if list(log.input_variables) != known:
            raise LogError(
                f"got {', '.join(log.input_variables) or 'none'}",
                expected=f"the inputs of this program's {component.name!r}: {', '.join(known) or 'none'}",
                at="header.inputs",
                source=f"log {str(log.path)!r}",
            )
        if log.step_size != component.step_size:
            raise LogError(
                f"got {log.step_size!r} s",
                expected=f"the step_size that its parameters give, {component.step_size!r} s",
                at="header.step_size",
                hint="parameters or header were changed",
                source=f"log {str(log.path)!r}",
            )

    # -- the result -------------------------------------------------------------------------------------------------

    def _differs(self, variable: str, span: tuple[int, int], reason: str, index: int | None) -> None:
        first, last = (tick * self.log.step_size for tick in span)
        where = "" if index is None else f"[{index}]"
        when = f"at {first:.12g} s (tick {span[0]})"
        if span[0] != span[1]:
            when = f"between {first:.12g} s and {last:.12g} s (ticks {span[0]} to {span[1]})"
        self._add(variable, f"{variable}{where} differs {when}" + (f": {reason}" if reason else ""), index, (first, last))

    def _add(self, variable: str, sentence: str, index: int | None = None, interval: tuple[float, float] | None = None) -> None:
        """Note a difference; the first one is the result's."""
        result = self.result
        result.notes.append(sentence)
        if result.variable is None:
            result.variable, result.index, result.interval = variable, index, interval
