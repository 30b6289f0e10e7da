"""Re-run a log and compare every bit that it holds: frames, hashes, snapshots, inputs."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np

from ..components.contract import Component, Held, Snapshot, StepError
from ..components.errors import GranularError, LogError
from .batch import hash_row, held_word, step_digests
from .facts import machine, versions
from .format import FRAMES, HASHES, SNAPSHOTS, STEPS, words
from .index import DETAIL, FIRST, Segment
from .reader import Log, open_log, restore
from .steps import raw_sets
from .track import LEDGER

Changes = list[tuple[int, dict[str, Held]]]


@dataclass(slots=True)
class Verification:
    """What a re-run found.

    Attributes:
        path: the log.
        identical: whether every bit that was compared is the same.
        complete: whether the log was closed; otherwise only what it holds was compared.
        steps, ticks: calls of `step` and internal steps that were run again.
        frames, hashes, snapshots: how many of each were compared.
        variable: name of the first variable that differs.
        index: its first element that differs, or None where that is not known.
        interval: times between which the difference arose: last agreeing, first differing [s].
        message: one or a few sentences for people.
    """

    path: str
    complete: bool
    identical: bool = True
    steps: int = 0
    ticks: int = 0
    frames: int = 0
    hashes: int = 0
    snapshots: int = 0
    variable: str | None = None
    index: int | None = None
    interval: tuple[float, float] | None = None
    message: str = ""
    notes: list[str] = field(default_factory=list)

    def __bool__(self) -> bool:
        return self.identical


@dataclass(frozen=True, slots=True)
class _Difference(Exception):  # noqa: N818 - a finding, carried out of nested loops
    variable: str
    tick: int
    index: int | None = None
    reason: str = ""


def verify(
    path: str | os.PathLike[str] | Log,
    *,
    progress: Callable[[float], None] | None = None,
    allow_large: bool = False,
    components: Mapping[str, type[Component]] | None = None,
) -> Verification:
    """Re-run a log from its parameters, start states and inputs, and compare all that it holds, bit for bit.

    Args:
        path: the log.
        progress: called now and then with the part that is done, 0 to 1.
        allow_large: lift the caps on sizes.
        components: classes of components that are not ours, by name.

    Raises:
        LogError: the file is no log, or it is damaged, or it cannot be re-run at all. A log that can be re-run but gives
            other bits is no error: the result names the first variable and the interval.
    """
    log = path if isinstance(path, Log) else open_log(path, allow_large=allow_large)
    try:
        return _Replay(log, progress, components).run()
    finally:
        if log is not path:
            log.close()


class _Replay:
    def __init__(self, log: Log, progress: Callable[[float], None] | None, components: Any) -> None:
        self.log, self._progress = log, progress
        self.component = log.rebuilt(components)
        self._trusted = self.component.identity == log._header.get("identity")
        self._agreed: dict[str, int] = {}
        self._ledger: tuple[int, Any] = (-1, None)
        self.result = Verification(str(log.path), log.complete)

    def run(self) -> Verification:
        log, result = self.log, self.result
        log._caps.work(log.end_tick - log.start_tick, len(self.component._block.memory))
        self._check_header()
        for segment in log.segments:
            try:
                self._run_segment(segment)
            except _Difference as found:
                self._report(segment, found)
                break
            result.steps += len(log.steps_of(segment))
            result.ticks += segment.end - segment.start
        self._check_step_digests()
        if not self._trusted and result.identical:
            self._differs("parameters", (log.start_tick, log.end_tick), "", None)
        self._conclude()
        return result

    # -- one segment ------------------------------------------------------------------------------------------------

    def _run_segment(self, segment: Segment) -> None:
        component, start = self.component, self.log.snapshot(segment, segment.start)
        restore(component, self._adopted(start))
        self._agreed = {}
        changes = self.log.steps_of(segment).changes(start.inputs)
        changes.reverse()
        for tick, check, *facts in heapq.merge(*self._marks(segment), key=itemgetter(0)):
            self._advance(changes, tick)
            check(tick, *facts)
        self._advance(changes, segment.end)

    def _advance(self, changes: Changes, tick: int) -> None:
        try:
            advance(self.component, changes, tick, self._tell)
        except StepError as error:
            at = round(error.time / self.component.step_size)
            raise _Difference(
                error.variable, at, error.index, f"the re-run broke down where the log went on: {error}"
            ) from error

    def _tell(self) -> None:
        if self._progress is not None:
            total = max(self.log.end_tick - self.log.start_tick, 1)
            start = next((s for s in self.log.segments if s.start <= self.component.tick <= s.end), None)
            done = self.result.ticks + (self.component.tick - start.start if start else 0)
            self._progress(min(done / total, 1.0))

    def _marks(self, segment: Segment) -> list[Iterator[tuple[Any, ...]]]:
        rows = self.log._rows(FRAMES)
        rows = rows[rows[:, 2] == segment.number]
        found = [self._frame_marks(rows[rows[:, DETAIL] == n], name) for n, name in enumerate(self.log.variables)]
        return [*found, self._hash_marks(segment), self._snapshot_marks(segment)]

    def _frame_marks(self, rows: np.ndarray, name: str) -> Iterator[tuple[Any, ...]]:
        for row in rows:
            ticks, values = self.log._frames(row, name)
            for tick, value in zip(ticks.tolist(), values, strict=True):
                yield tick, self._check_frame, name, value

    def _hash_marks(self, segment: Segment) -> Iterator[tuple[Any, ...]]:
        for row in self.log._index.select(HASHES, 0, segment.number):
            record = self.log._record(row)
            ticks, rows = record.arrays.get("ticks"), record.arrays.get("rows")
            width = len(self._hashed())
            if ticks is None or rows is None or rows.shape != (record.count, width) or ticks.shape != (record.count,):
                raise LogError(f"log {str(self.log.path)!r}: a record of hashes has the wrong form")
            if rows.dtype != np.int64 or ticks.dtype != np.int64 or (np.diff(ticks) <= 0).any() or ticks[0] < row[FIRST]:
                raise LogError(f"log {str(self.log.path)!r}: a record of hashes has the wrong form")
            for tick, own in zip(ticks.tolist(), rows, strict=True):
                yield tick, self._check_hash, own

    def _snapshot_marks(self, segment: Segment) -> Iterator[tuple[Any, ...]]:
        for row in self.log._index.select(SNAPSHOTS, None, segment.number):
            yield int(row[FIRST]), self._check_snapshot, row

    # -- comparing --------------------------------------------------------------------------------------------------

    def _check_frame(self, tick: int, name: str, value: np.ndarray) -> None:
        if words(np.asarray(self._value(name), dtype=np.float64)) != words(value):
            own = np.atleast_1d(np.asarray(self._value(name), dtype=np.float64)).view(np.int64).ravel()
            index = (
                int(np.argmax(own != np.atleast_1d(np.ascontiguousarray(value)).view(np.int64).ravel())) if value.ndim else None
            )
            raise _Difference(name, tick, index)
        self._agreed[name] = tick
        self.result.frames += 1

    def _check_hash(self, tick: int, row: np.ndarray) -> None:
        own = hash_row(self.component, self._state(), list(self.log.input_variables))
        for name, here, there in zip(self._hashed(), own.tolist(), row.tolist(), strict=True):
            if here != there:
                raise _Difference(name, tick)
            self._agreed[name] = tick
        self.result.hashes += 1

    def _check_snapshot(self, tick: int, row: np.ndarray) -> None:
        snapshot = self._adopted(self.log._snapshot(row))
        mine = self.component.save()
        for name, value in mine.inputs.items():
            if name not in snapshot.inputs or held_word(snapshot.inputs[name]) != held_word(value):
                raise _Difference(name, tick)
        if words(snapshot.memory) != words(mine.memory):
            raise _Difference(self._culprit(snapshot), tick)
        self._agreed["state"] = tick
        self.result.snapshots += 1

    def _culprit(self, snapshot: Snapshot) -> str:
        """Which state variable a differing snapshot differs in."""
        mine = {name: words(self.component.get(name)) for name in self._state()}
        restore(self.component, snapshot)
        return next((name for name, bits in mine.items() if words(self.component.get(name)) != bits), "state")

    def _value(self, name: str) -> Any:
        if name not in LEDGER:
            return self.component.get(name)
        if self._ledger[0] != self.component.tick:
            self._ledger = (self.component.tick, self.component.ledger())
        return getattr(self._ledger[1], name)

    def _adopted(self, snapshot: Snapshot) -> Snapshot:
        """With changed parameters, go on all the same: the first difference is what people want to know."""
        if snapshot.identity == self.log._header.get("identity"):
            snapshot.identity = self.component.identity
        return snapshot

    def _state(self) -> list[str]:
        return [v.name for v in self.component.variables.values() if v.state]

    def _hashed(self) -> list[str]:
        return [*self._state(), "state", *self.log.input_variables]

    # -- what the header and the second account of the inputs say ---------------------------------------------------------

    def _check_header(self) -> None:
        log, component = self.log, self.component
        for name, variable in log.variables.items():
            mine = component.variables.get(name)
            if mine is None or mine.shape != variable.shape or mine.causality != variable.causality:
                raise LogError(
                    f"log {str(log.path)!r}: this program's {component.name!r} has no {name!r} of shape {variable.shape}"
                )
        known = [v.name for v in component.variables.values() if v.causality == "input"]
        if list(log.input_variables) != known:
            raise LogError(f"log {str(log.path)!r}: this program's {component.name!r} has other inputs: {', '.join(known)}")
        if log.step_size != component.step_size:
            self._differs("step_size", (log.start_tick, log.end_tick), "the parameters give another internal step", None)
            raise LogError(
                f"log {str(log.path)!r}: its parameters give a step_size of {component.step_size!r} s, its header says "
                f"{log.step_size!r} s; parameters or header were changed"
            )

    def _check_step_digests(self) -> None:
        rows = self.log._rows(STEPS)
        accounts = self.log._rows(HASHES)
        accounts = accounts[accounts[:, DETAIL] == 1]
        for row, account in zip(rows, accounts, strict=False):
            record = self.log._record(row)
            mine = step_digests(record.arrays["durations"], raw_sets(record, list(self.log.input_variables)))
            told = self.log._record(account).header.get("steps")
            if mine != told:
                names = [
                    n
                    for n in {*mine, *(told if isinstance(told, dict) else {})}
                    if not isinstance(told, dict) or mine.get(n) != told.get(n)
                ]
                name = next((n for n in sorted(names) if n), "the steps' lengths")
                span = (self.log._log_tick(row[2], record.first), self.log._log_tick(row[2], record.last))
                self._differs(name, span, f"input {name!r} is not what was recorded", None)
                return

    # -- the result -------------------------------------------------------------------------------------------------

    def _report(self, segment: Segment, found: _Difference) -> None:
        before = self._agreed.get(found.variable, segment.start)
        span = (self.log._log_tick(segment.number, before), self.log._log_tick(segment.number, found.tick))
        self._differs(found.variable, span, found.reason, found.index)

    def _differs(self, variable: str, span: tuple[int, int], reason: str, index: int | None) -> None:
        result, step_size = self.result, self.log.step_size
        interval = (span[0] * step_size, span[1] * step_size)
        where = "" if index is None else f"[{index}]"
        sentence = (
            f"{variable}{where} differs between {interval[0]:.12g} s and {interval[1]:.12g} s "
            f"(internal steps {span[0]} to {span[1]})"
        )
        result.notes.append(sentence + (f": {reason}" if reason else ""))
        if result.identical:
            result.identical, result.variable, result.index, result.interval = False, variable, index, interval

    def _conclude(self) -> None:
        result = self.result
        if not self._trusted:
            result.notes.append(
                "the log's parameters do not give the identity that it claims: they were changed, or the program was"
            )
        if not result.identical:
            result.notes += _foreign_facts(self.log._header)
        compared = (
            f"{result.steps} steps compared ({result.ticks} internal steps, {result.frames} frames, "
            f"{result.hashes} hashes, {result.snapshots} snapshots)"
        )
        ending = "" if result.complete else " The log was not closed; what it holds was compared."
        result.message = (
            f"{compared}: {'identical' if result.identical else 'NOT identical; ' + '; '.join(result.notes)}.{ending}"
        )


def advance(component: Component, changes: Changes, tick: int, tell: Callable[[], None] | None = None) -> None:
    """Run to a tick in as few long steps as the changes of inputs allow; `changes` is reversed, and used up.

    A step of n ticks gives the bits of n steps of one, so this is as exact as the original steps and faster.
    """
    try:
        while component.tick < tick:
            inputs: dict[str, Held] = {}
            while changes and changes[-1][0] <= component.tick:
                inputs.update(changes.pop()[1])
            stop = min(tick, changes[-1][0]) if changes else tick
            component.step((stop - component.tick) * component.step_size, **inputs)
            if tell is not None:
                tell()
    except StepError:
        raise
    except GranularError as error:
        raise LogError(f"the log sets an input that its component refuses: {error}") from error


def _foreign_facts(header: Mapping[str, Any]) -> list[str]:
    """Versions and CPU that are not those of the recording, in case they are the reason."""
    told = {**_dict(header.get("versions")), **_dict(header.get("machine"))}
    mine = {**versions(), **machine()}
    return [
        f"{name} was {told[name]!r} and is {value!r} now"
        for name, value in mine.items()
        if name in told and told[name] != value
    ]


def _dict(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
