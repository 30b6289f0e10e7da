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
from ..writing import counted
from .accounts import changed_input, changed_parameters
from .batch import hash_row, held_word
from .facts import machine, versions
from .format import FRAMES, HASHES, SNAPSHOTS, words
from .index import DETAIL, FIRST, Segment
from .reader import Log, open_log, restore
from .track import LEDGER

Changes = list[tuple[int, dict[str, Held]]]
# What differs, the ticks of the log between which that arose, why (if known), which element.
_Found = tuple[str, tuple[int, int], str, int | None]


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
        if not self._trusted and result.identical:
            self._differs("parameters", (log.start_tick, log.end_tick), "", None)
        result.notes += [f"it cannot be re-run with them: {why_not}"] if why_not else []
        self._conclude()
        return result

    def _first_difference(self) -> _Found | None:
        for segment in self.log.segments:
            try:
                self._run_segment(segment)
            except _Difference as found:
                before = self._agreed.get(found.variable, segment.start)
                first, last = (self.log._log_tick(segment.number, tick) for tick in (before, found.tick))
                return found.variable, (first, last), found.reason, found.index
            self.result.steps += len(self.log.steps_of(segment))
            self.result.ticks += segment.end - segment.start
        return None

    def _name_causes(self, parameters: list[str], changed: tuple[str, tuple[int, int]] | None, found: _Found | None) -> None:
        """What was changed comes first, in the interval where that shows; then what came of it."""
        whole = self.log.start_tick, self.log.end_tick
        for name in parameters:
            # Where it shows at once, as in the energy of the start, nothing is narrowed down.
            span = found[1] if found and found[1][0] < found[1][1] else whole
            self._differs(name, span, "this parameter is not what was recorded", None)
        if changed is not None:
            name, (first, last) = changed
            if found is None or found[1][1] > first:
                if found is not None and found[1][0] < last:
                    first, last = max(first, found[1][0]), min(last, found[1][1])
                self._differs(name, (first, last), f"input {name!r} is not what was recorded", None)
                changed = None
        if found is not None:
            self._differs(*found)
        if changed is not None:
            self._differs(*changed, f"input {changed[0]!r} is not what was recorded", None)

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
        # At the same tick the inputs come first: a difference in them is the cause, one in the state what came of it.
        held, hashed = (self._hash_marks(segment, check) for check in (self._check_held, self._check_hash))
        return [held, *found, hashed, self._snapshot_marks(segment)]

    def _frame_marks(self, rows: np.ndarray, name: str) -> Iterator[tuple[Any, ...]]:
        for row in rows:
            ticks, values = self.log._frames(row, name)
            for tick, value in zip(ticks.tolist(), values, strict=True):
                yield tick, self._check_frame, name, value

    def _hash_marks(self, segment: Segment, check: Callable[..., None]) -> Iterator[tuple[Any, ...]]:
        for row in self.log._index.select(HASHES, 0, segment.number):
            record = self.log._record(row)
            ticks, rows = record.arrays.get("ticks"), record.arrays.get("rows")
            width = len(self._hashed())
            if ticks is None or rows is None or rows.shape != (record.count, width) or ticks.shape != (record.count,):
                raise LogError(f"log {str(self.log.path)!r}: a record of hashes has the wrong form")
            if rows.dtype != np.int64 or ticks.dtype != np.int64 or (np.diff(ticks) <= 0).any() or ticks[0] < row[FIRST]:
                raise LogError(f"log {str(self.log.path)!r}: a record of hashes has the wrong form")
            for tick, own in zip(ticks.tolist(), rows, strict=True):
                yield tick, check, own

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

    def _check_held(self, tick: int, row: np.ndarray) -> None:
        names = list(self.log.input_variables)
        for name, word in zip(names, row.tolist()[-len(names) :] if names else [], strict=True):
            if held_word(self.component._held[name]) != word:
                raise _Difference(name, tick)
            self._agreed[name] = tick

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
        if snapshot.identity != self.log._header.get("identity"):
            self._trusted = False
        snapshot.identity = self.component.identity
        return snapshot

    def _state(self) -> list[str]:
        return [v.name for v in self.component.variables.values() if v.state]

    def _hashed(self) -> list[str]:
        return [*self._state(), "state", *self.log.input_variables]

    # -- what the header says -----------------------------------------------------------------------------------------------

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
            raise LogError(
                f"log {str(log.path)!r}: its parameters give a step_size of {component.step_size!r} s, its header says "
                f"{log.step_size!r} s; parameters or header were changed"
            )

    # -- the result -------------------------------------------------------------------------------------------------

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
                "the log's parameters do not give the identity that it or its snapshots claim: they were changed, or the "
                "program was"
            )
        if not result.identical:
            result.notes += _foreign_facts(self.log._header)
        compared = (
            f"{counted(result.steps, 'step')} compared ({counted(result.ticks, 'internal step')}, "
            f"{counted(result.frames, 'frame')}, {counted(result.hashes, 'hash', 'hashes')}, "
            f"{counted(result.snapshots, 'snapshot')})"
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
