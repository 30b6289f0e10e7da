"""Verification: run a log again, and compare its frames, hashes, snapshots, inputs and events bitwise."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any, Literal

import numpy as np

from ..components.component import Component
from ..components.errors import LogError, StepError
from ..components.snapshot import Snapshot
from ..output_files import count_text
from ..progress import Progress, progress_bar
from .header import header_table, machine_facts, versions
from .index import DETAIL, FIRST, LAST, Segment
from .log import Log, open_log
from .records import EVENTS, FRAMES, HASHES, SNAPSHOTS, input_word, make_hash_row, value_bits
from .replay import Changes, advance_to_tick, check_work, restore_snapshot

Outcome = Literal["identical", "different", "incomplete", "nothing was compared"]


@dataclass(slots=True, repr=False)
class Verification:
    """The findings of a verification.

    Attributes:
        path: the log.
        complete: whether the log was closed.
        calls, ticks: number of calls of `step` and number of ticks that were run again.
        frames: number of times at which recorded variables were compared.
        hashes, snapshots: numbers of compared hashes and snapshots.
        variable: name of the first differing variable, "events" or "identity"; None without a difference.
        index: index of the first differing element, or None if unknown.
        interval: last time at which the variable agreed, and first time at which it differed [s]; None for the identity.
        notes: sentences on the difference and its possible causes, and on parts of the run missing in the log.
        incidents: incidents of the recording, such as "failed" or "recovered"; not compared.
    """

    path: str
    complete: bool
    calls: int = 0
    ticks: int = 0
    frames: int = 0
    hashes: int = 0
    snapshots: int = 0
    variable: str | None = None
    index: int | None = None
    interval: tuple[float, float] | None = None
    notes: list[str] = field(default_factory=list)
    incidents: list[str] = field(default_factory=list)

    @property
    def outcome(self) -> Outcome:
        """The result of the verification in one or two words."""
        if self.variable is not None:
            return "different"
        if not self.ticks:
            return "nothing was compared"
        return "identical" if self.complete else "incomplete"

    @property
    def identical(self) -> bool:
        """Return whether the log was closed, contains at least one tick, and all bits of the repetition are the same."""
        return self.outcome == "identical"

    @property
    def message(self) -> str:
        """The result as text: a line with the counts, then one line per difference and one per part missing in the log."""
        hashes = count_text(self.hashes, "hash", "hashes")
        kinds = f"{count_text(self.frames, 'frame')}, {hashes}, {count_text(self.snapshots, 'snapshot')}"
        size = f"{count_text(self.calls, 'call')} of step, {count_text(self.ticks, 'tick')} ({kinds})"
        summary = {
            "identical": f"{size} compared bit for bit",
            "different": f"{size if self.ticks else kinds} agree{'' if self.complete else '; the log was not closed'}",
            "incomplete": f"the log was not closed; its contents agree bit for bit: {size}",
            "nothing was compared": f"the log contains no call of step{'' if self.complete else '; the log was not closed'}",
        }
        lines = [f"{self.outcome}: {summary[self.outcome]}", *self.notes]
        if self.variable is None and self.incidents:
            lines.append(f"not compared: incidents of the recording ({', '.join(dict.fromkeys(self.incidents))})")
        return "\n".join(lines)

    def __bool__(self) -> bool:
        return self.identical

    def __repr__(self) -> str:
        return f"<Verification of {self.path!r}: {self.message.splitlines()[0]}>"


class Difference(Exception):  # noqa: N818 - a finding, carried out of nested loops
    """A difference between the log and the repeated run: variable, tick in the segment, element and explanation."""

    def __init__(self, variable: str, tick: int, index: int | None = None, reason: str = "") -> None:
        super().__init__(variable)
        self.variable, self.tick, self.index, self.reason = variable, tick, index, reason


def verify(
    path: str | os.PathLike[str] | Log,
    *,
    progress: Progress = False,
    allow_large: bool = False,
    components: Mapping[str, type[Component]] | None = None,
) -> Verification:
    """Run a log again from its parameters, start states and inputs, and compare its records bitwise.

    Titles, dates, descriptions and other texts are not compared.

    Args:
        path: the log.
        progress: show a bar, or call this regularly with the completed fraction.
        allow_large: lift the limits on sizes.
        components: component classes outside this package, by name; an open log has its own.

    Raises:
        LogError: not a log, a damaged log, or a log that cannot be run again. Different bits are not an error: the result
            names the first differing variable and the interval.
    """
    log = path if isinstance(path, Log) else open_log(path, allow_large=allow_large, components=components)
    try:
        component, total = log.new_component(), log.end_tick - log.start_tick
        check_work(total, component, log.limits)
        _refuse_other_declaration(log, component)
        result = Verification(str(log.path), log.complete)
        for incident in log.incidents:
            result.incidents.append(str(incident.get("incident")))
            if incident.get("incident") == "unrecorded":
                result.notes.append(str(incident.get("message"))[:400])
        with progress_bar(f"verification of {log.path.name}", max(total, 1), show=progress) as bar:
            # Include empty segments, which contain a state and possibly a frame.
            for segment in log.index.all_segments:
                comparison, before = Comparison(log, component, segment, result), result.ticks - segment.start

                def report_progress(tick: int, before: int = before) -> None:
                    if bar.is_due():
                        bar.update(before + tick)

                try:
                    comparison.run(log.snapshot(segment, segment.start), segment.end, report_progress)
                except Difference as found:
                    _store_difference(result, log, segment, found, comparison.agreed.get(found.variable, segment.start))
                    break
                result.calls += len(log.step_history(segment))
                result.ticks += segment.end - segment.start
        if component.identity != log.header.get("identity"):
            result.variable = result.variable or "identity"
            result.notes.append(
                "the log's parameters do not match the identity stated in it: the parameters or the program were changed"
            )
        if result.variable is not None:
            result.notes += _version_differences(log.header)
        return result
    finally:
        if log is not path:
            log.close()


def _store_difference(result: Verification, log: Log, segment: Segment, difference: Difference, agreed: int) -> None:
    """Store a difference in the result; `agreed` is the last tick at which log and repeated run had the same variable."""
    first, last = (log.log_tick(segment.number, tick) for tick in (agreed, difference.tick))
    result.variable, result.index = difference.variable, difference.index
    result.interval = (first * log.step_size, last * log.step_size)
    where = "" if difference.index is None else f"[{difference.index}]"
    when = f"at {result.interval[0]:.12g} s (tick {first})"
    if first != last:
        when = "between {:.12g} s and {:.12g} s".format(*result.interval) + f" (ticks {first} to {last})"
    reason = f": {difference.reason}" if difference.reason else ""
    result.notes.append(f"{difference.variable}{where} differs {when}{reason}")


class Comparison:
    """A repeated run of a part of a segment, which is compared with the records of the log.

    Attributes:
        agreed: last tick at which each variable agreed.
    """

    def __init__(self, log: Log, component: Component, segment: Segment, result: Verification) -> None:
        self.agreed: dict[str, int] = {}
        self._log, self._component, self._segment, self._result = log, component, segment, result
        self._inputs = list(log.input_variables)
        self._state = [v.name for v in component.variables.values() if v.state]
        self._framed, self._balances = -1, {}

    def run(self, start: Snapshot, end: int, report: Callable[[int], None] | None = None) -> None:
        """Run from a snapshot of the segment to a tick.

        Args:
            start: snapshot of the segment; its identity is not compared.
            end: the tick to reach; later records are not compared.
            report: called after each piece of the run with the tick reached.

        Raises:
            Difference: the log differs from the repetition.
            LogError: the log is damaged, or cannot be run again.
        """
        component, segment, log = self._component, self._segment, self._log
        self._restore_snapshot(start)
        before = component.event_count
        held = log.snapshot(segment, segment.start).inputs
        changes = [change for change in log.step_history(segment).input_changes(held) if change[0] >= start.tick]
        changes.reverse()

        for at, check, *facts in heapq.merge(*self._comparisons(start.tick, end), key=itemgetter(0)):
            self._advance_component(changes, at, report)
            check(at, *facts)
        self._advance_component(changes, end, report)
        if component.event_kinds:
            self._compare_events(start.tick, end, component.event_rows(before))

    def _advance_component(self, changes: Changes, tick: int, report: Callable[[int], None] | None) -> None:
        try:
            advance_to_tick(self._component, changes, tick, report)
        except StepError as error:
            at = round(error.time / self._component.step_size)
            reason = f"the re-run failed at a step that succeeded in the log: {error}"
            raise Difference(error.variable, at, error.index, reason) from error

    def _comparisons(self, start: int, end: int) -> list[Iterator[tuple[Any, ...]]]:
        """Return, per kind, the comparisons to make in the order of time: tick, the function that compares, its arguments."""
        index, number = self._log.index, self._segment.number
        frames = index.select_rows(FRAMES, None, number)
        # Compare inputs first at each tick, because different inputs cause a different state.
        marks = [
            self._hash_comparisons(index.select_rows(HASHES, 0, number), self._check_inputs),
            *(self._frame_comparisons(frames[frames[:, DETAIL] == n], name) for n, name in enumerate(self._log.variables)),
            self._hash_comparisons(index.select_rows(HASHES, 0, number), self._check_hash),
            ((int(row[FIRST]), self._check_snapshot, row) for row in index.select_rows(SNAPSHOTS, None, number)),
        ]
        return [(mark for mark in kind if start <= mark[0] <= end) for kind in marks]

    def _frame_comparisons(self, rows: np.ndarray, name: str) -> Iterator[tuple[Any, ...]]:
        for row in rows:
            ticks, values = self._log.frames(row, name)
            for tick, value in zip(ticks.tolist(), values, strict=True):
                yield tick, self._check_frame, name, value

    def _hash_comparisons(self, rows: np.ndarray, check: Callable[..., None]) -> Iterator[tuple[Any, ...]]:
        for row in rows:
            ticks, digests = self._log.hash_rows(row, len(self._state) + 1 + len(self._inputs))
            for tick, own in zip(ticks.tolist(), digests, strict=True):
                yield tick, check, own

    def _check_frame(self, tick: int, name: str, value: np.ndarray) -> None:
        component = self._component
        if self._framed != tick:
            self._framed, self._balances = tick, component.balance_values()
            self._result.frames += 1
        mine = np.asarray(self._balances[name] if name in self._balances else component.get(name), dtype=np.float64)
        if value_bits(mine) != value_bits(value):
            differs = np.frombuffer(value_bits(mine), np.int64) != np.frombuffer(value_bits(value), np.int64)
            raise Difference(name, tick, int(np.argmax(differs)) if value.ndim else None)
        self.agreed[name] = tick

    def _check_inputs(self, tick: int, row: np.ndarray) -> None:
        held = self._component.held_inputs
        self._compare_words(tick, self._inputs, [input_word(held[name]) for name in self._inputs], row[len(self._state) + 1 :])

    def _check_hash(self, tick: int, row: np.ndarray) -> None:
        names = [*self._state, "state", *self._inputs]
        self._compare_words(tick, names, make_hash_row(self._component, self._state, self._inputs), row)
        self._result.hashes += 1

    def _compare_words(self, tick: int, names: Sequence[str], repeated: Any, logged: np.ndarray) -> None:
        for name, mine, other in zip(names, repeated, logged, strict=True):
            if mine != other:
                raise Difference(name, tick)
            self.agreed[name] = tick

    def _check_snapshot(self, tick: int, row: np.ndarray) -> None:
        snapshot, mine = self._log.read_snapshot(row), self._component.save()
        reason = f"the snapshot at {tick * self._log.step_size:.12g} s differs from the state of the re-run"
        for name, value in mine.inputs.items():
            if name not in snapshot.inputs or input_word(snapshot.inputs[name]) != input_word(value):
                raise Difference(name, tick, None, reason)
        if value_bits(snapshot.memory) != value_bits(mine.memory):
            values = {name: value_bits(self._component.get(name)) for name in self._state}
            self._restore_snapshot(snapshot)
            differing = (name for name, value in values.items() if value_bits(self._component.get(name)) != value)
            raise Difference(next(differing, "state"), tick, None, reason)
        self.agreed["state"] = tick
        self._result.snapshots += 1

    def _compare_events(self, start: int, end: int, repeated: np.ndarray) -> None:
        """Compare the events of the repeated run with the events in the log."""
        log, number = self._log, self._segment.number
        recorded = [log.event_rows(row) for row in log.index.select_rows(EVENTS, None, number) if row[LAST] > start]
        rows = np.concatenate([*recorded, np.zeros((0, 5))])
        rows = rows[(rows[:, 0] > start) & (rows[:, 0] <= end)]
        count = min(len(rows), len(repeated))
        same = (rows[:count].view(np.int64) == repeated[:count].view(np.int64)).all(axis=1)
        if not same.all() or len(rows) > len(repeated):
            place = int(np.argmin(same)) if not same.all() else count
            self.agreed["events"] = int(rows[place - 1, 0]) if place else start
            raise Difference("events", int(rows[place, 0]))
        if len(repeated) > count:
            raise Difference("events", int(repeated[count, 0]), None, "the re-run has events that are not in the log")

    def _restore_snapshot(self, snapshot: Snapshot) -> None:
        """Restore a snapshot even if parameters differ from the log's, so that the first different variable can be found."""
        snapshot.identity = self._component.identity
        restore_snapshot(self._component, snapshot)


def _refuse_other_declaration(log: Log, component: Component) -> None:
    """Raise an error if variables, inputs or the step size in the log differ from those of the present component."""
    where = f"this program's {component.name!r}"
    for name, variable in log.variables.items():
        mine = component.variables.get(name)
        if mine is None or mine.shape != variable.shape or mine.causality != variable.causality:
            came = f"{where} has no {name!r} of shape {variable.shape}"
            raise LogError(came, at="header.variables", source=log.source)
    known = [v.name for v in component.variables.values() if v.causality == "input"]
    for key, got, expected in (("inputs", list(log.input_variables), known), ("step_size", log.step_size, component.step_size)):
        if got != expected:
            raise LogError(f"got {got}", expected=f"{expected}, as in {where}", at=("header", key), source=log.source)


def _version_differences(header: Mapping[str, Any]) -> list[str]:
    """Return sentences on the versions and machine data that differ from those in the log, as possible causes."""
    recorded = {**header_table(header.get("versions")), **header_table(header.get("machine"))}
    return [
        f"{name} was {recorded[name]!r} and is {value!r} now"
        for name, value in {**versions(), **machine_facts()}.items()
        if name in recorded and recorded[name] != value
    ]
