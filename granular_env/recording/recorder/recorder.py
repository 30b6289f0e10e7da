"""The recorder: an observer that writes what a component does, without ever changing it.

The stepping thread only appends to lists. One daemon thread does all the writing, every few hundredths of a second, also
while the script sits idle: so a killed process loses at most the last tenth of a second, and Ctrl-C never cuts a write.
"""

from __future__ import annotations

import atexit
import dataclasses
import json
import threading
import warnings
import weakref
from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ...components.component import Component
from ...components.errors import GranularError, LogError
from ...components.inputs import Held
from ...components.support.serialization import canonical_json
from ..format.digests import hash_row, header_digests, parameter_digests
from ..format.header import closing_facts, header_of
from ..format.metadata import metadata_of, title_of
from ..format.records import CLOSED, END, HEADER, INCIDENTS, KEY, START, Record, nanoseconds
from ..preview.frames import PreviewFrames, facts_of, film_facts_of_frames
from .buffer_pool import BufferPool
from .log_file import LogFile
from .log_writer import LogWriter
from .record_batch import Profiles, RecordBatch, write_batch
from .sampling import Agenda, Schedule

if TYPE_CHECKING:
    from ..replay.continuation import Continuation

# Age at which gathered data is written [s], and at which a step waits until it has been: a stepping thread that never pauses
# leaves the writing one too little of the interpreter, and what a kill may cost is promised to be less than 100 ms.
_WRITE_SECONDS, _WAIT_SECONDS = 0.03, 0.045
_LONGEST_WAIT = 0.5
# Gathered bytes at which the writing thread is woken, and at which the stepping thread waits for it.
_WAKE_BYTES, _WAIT_BYTES = 4 << 20, 64 << 20
_STEP_BYTES, _SET_BYTES = 40, 100


class Recorder:
    """See `record`. Use it as a context manager, or call `close`.

    Attributes:
        path: where the log is.
        next_tick: the tick at which it wants to look next.
    """

    def __init__(
        self,
        component: Component,
        path: Any,
        file: LogFile,
        names: list[str],
        schedule: Schedule,
        experiment: Any = None,
        parent: Any = None,
        elapsed: int = 0,
        continuation: Continuation | None = None,
    ) -> None:
        """Write the header, or what is kept of a log that goes on, and begin to look; `record` checks its arguments."""
        self.path, self.next_tick = path, 0
        self._component, self._names, self._schedule = component, names, schedule
        self._state = [v.name for v in component.variables.values() if v.state]
        self._inputs = {v.name: v.shape for v in component.variables.values() if v.causality == "input"}
        self._elapsed = self._before = elapsed
        # How many of the component's events have been taken, or were there when the segment began.
        self._has_events, self._events = bool(component.event_kinds), 0
        self._segment, self._frames = -1, 0
        self._expected, self._agenda = 0, Agenda(schedule)
        self._lock, self._wake, self._written = threading.Lock(), threading.Event(), threading.Condition()
        self._closing = self._closed = self._ended = False
        self._waiting: list[RecordBatch | tuple[Record, int]] = []
        self._backlog = 0
        self._error: GranularError | None = None
        self._continuation, self._film_facts = continuation, {}
        self._track = PreviewFrames(facts_of(component, title_of({"experiment": experiment, "component": component.name})))
        self._profiles = Profiles()
        self._batch = self._inside = RecordBatch(-1, 0, 0)
        self._pool = BufferPool()
        # Ticks of the step under way that have been handed over; frames that no failure takes back.
        self._parts = self._taken_frames = 0
        self._file, self._sink = file, LogWriter(path, file)
        try:
            if continuation is None:
                self._write_header(experiment, parent)
            else:
                continuation.copy_to(self._sink)
        except BaseException:
            self._sink.abandon()
            raise
        self._due = perf_counter() + _WAIT_SECONDS
        component.observe(self)
        # The thread knows it weakly: a recorder that nobody holds any more, nor the component, is closed and collected.
        self._thread = threading.Thread(
            target=_write_on, args=(weakref.ref(self), self._wake), name=f"granular-env log {path}", daemon=True
        )
        self._thread.start()
        _OPEN.add(self)
        _FILES.add(file)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        try:
            self.close()
        except LogError:
            # What already went wrong matters more than that it could not be recorded.
            if kind is None:
                raise

    def __del__(self) -> None:
        if getattr(self, "_thread", None) is not None and not self._closed:
            warnings.warn(
                f"the recorder of {str(self.path)!r} was never closed; use `with ge.record(...)`, or call close()",
                ResourceWarning,
                stacklevel=2,
                source=self,
            )
            try:
                self.close()
            except GranularError as error:
                warnings.warn(str(error), ResourceWarning, stacklevel=2)

    @property
    def published(self) -> bool:
        """Return whether the log stands under its name; not yet, where it replaces one and holds no step."""
        return self._sink.published

    @property
    def tick(self) -> int:
        """The component's integer time."""
        return self._component.tick

    # -- observing --------------------------------------------------------------------------------------------------

    def on_reset(self, component: Component) -> None:
        """Begin a new segment; where nothing happened in the last one, begin that one anew."""
        with self._lock:
            if self._continuation is not None:
                self._go_on(component, self._continuation)
                self._continuation = None
            else:
                self._begin(component)

    def on_sample(self, component: Component) -> None:
        """Take what is due at this tick; of a long step, hand over the part that is done.

        A step of n ticks is n steps of one, so a part is a step like any other. If the rest fails, the component is put
        back to where the step began, and that is a new segment.
        """
        if not self._closed and self._error is None:
            self._look(component, self._inside)
            # By size alone: what a log holds must not depend on how fast the machine was.
            if self._inside.size > _WAKE_BYTES:
                self._take_part(component)
        self.next_tick = self._agenda.after(component.tick, self._age(component.tick))

    def _take_part(self, component: Component) -> None:
        with self._lock:
            ticks, held = component.tick - self._expected, {} if self._parts else component.held_inputs
            self._parts += ticks
            self._take_step(component.tick, ticks, held)
        self._hurry()

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Note a whole step; raises `LogError` once if the log cannot be written, with the component's step done."""
        if self._closed:
            return
        now = component.tick
        with self._lock:
            rest, self._parts = ticks - self._parts, 0
            if now - rest != self._expected:
                # Ctrl-C fell between a step and its record: what is known for certain is the state now.
                self._begin(component)
                return
            if rest:
                self._take_step(now, rest, inputs if rest == ticks else {})
            size = self._batch.size
        if size > _WAKE_BYTES or perf_counter() > self._due:
            self._hurry()
            self._tell_error()

    def _take_step(self, now: int, ticks: int, inputs: Mapping[str, Held]) -> None:
        batch = self._batch
        if inputs:
            place = len(batch.durations)
            for name, value in inputs.items():
                batch.sets.append((place, name, value))
                batch.size += _SET_BYTES + (value.nbytes if isinstance(value, np.ndarray) else 0)
        batch.durations.append(ticks)
        batch.size += _STEP_BYTES
        self._expected = now
        if self._has_events:
            self._take_events(batch)
        if self._inside:
            batch.take(self._inside)
            self._inside = RecordBatch(batch.segment, 0, 0)
        self._taken_frames = self._frames

    def _take_events(self, batch: RecordBatch) -> None:
        """Take the events since the last step."""
        count = self._component.event_count
        if count > self._events:
            batch.events.append(self._component.event_rows(self._events))
            batch.size += batch.events[-1].nbytes
            self._events = count

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Forget what was seen inside the step that failed, unless its parts were handed over; keep the reason."""
        with self._lock:
            self._inside = RecordBatch(self._batch.segment, 0, 0)
            self._frames = self._taken_frames
            self._track.forget_from(self._frames)
            self._note("interrupted" if isinstance(error, KeyboardInterrupt) else "failed", error)
            if self._parts:
                self._parts = 0
                self._begin(component)
            else:
                self.next_tick = self._agenda.restart(component.tick, self._age(component.tick))

    # -- the end ----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Write the rest and the summary that makes the file complete; a second call does nothing.

        Raises:
            LogError: something could not be written; the path is named.
        """
        if self._closed:
            return
        if not self._closing:
            self._finish_batch()
            self._component.ignore(self)
            self._closing = True
        self._wake.set()
        # The collector of garbage may run in any thread.
        if threading.current_thread() is not self._thread:
            self._thread.join()
        if not self._ended:
            # It is being collected, and the thread, which knew it weakly, has gone.
            self._write_safely()
        self._closed = True
        _OPEN.discard(self)
        _FILES.discard(self._file)
        if self._error is not None:
            raise self._error

    def _finish_batch(self) -> None:
        with self._lock:
            if self._component.tick != self._expected:
                self._begin(self._component)
            self._inside = RecordBatch(self._batch.segment, 0, 0)
            if self._batch.durations or not self._batch.snapshots:
                self._batch.snapshots.append((self._expected, END, self._component.save()))
            film = {**self._film_facts, "stride": self._track.stride}
            self._closing_event = {"incident": "closed", "film": film, **closing_facts(self._component)}

    # -- inside the stepping thread ---------------------------------------------------------------------------------

    def _begin(self, component: Component) -> None:
        tick, batch = component.tick, self._batch
        # What was seen inside a step that is not recorded is forgotten.
        self._frames = self._taken_frames
        self._track.forget_from(self._frames)
        if batch.durations or batch.segment < 0 or not batch.snapshots or batch.snapshots[0][1] != START:
            self._before += batch.last - self._start_tick if batch.segment >= 0 else 0
            self._segment += 1
            if batch:
                self._waiting.append(batch)
                self._backlog += batch.size
        else:
            self._frames -= len(batch.frames)
            self._track.forget_from(self._frames)
        self._start_tick = self._expected = tick
        self._events = component.event_count
        self._batch = RecordBatch(self._segment, tick, self._before - tick)
        self._inside = RecordBatch(self._segment, 0, 0)
        self._batch.snapshots.append((tick, START, component.save()))
        self._batch.size += component.state_bytes
        self._batch.hashes.append((tick, hash_row(component, self._state, self._inputs)))
        if self._schedule.is_frame(tick, self._before):
            self._take_frame(component, self._batch)
        self._taken_frames = self._frames
        self.next_tick = self._agenda.restart(tick, self._age(tick))

    def _go_on(self, component: Component, kept: Continuation) -> None:
        """Take the place of the recorder that wrote what is kept of a log."""
        tick, self._segment = component.tick, 0
        self._start_tick, self._expected, self._events = kept.start, tick, component.event_count
        self._frames = self._taken_frames = kept.frames
        # What the preview shows beside the recorded variables is lost with the process that recorded them.
        self._track, self._film_facts = kept.film(), film_facts_of_frames()
        self._profiles.count, self._digests = kept.profiles, {}
        self._batch = RecordBatch(0, tick, self._before - kept.start)
        self._inside = RecordBatch(0, 0, 0)
        self._agenda.key = self._schedule.key_after(kept.key, self._age(kept.key))
        self.next_tick = self._agenda.after(tick, self._age(tick))

    def _look(self, component: Component, into: RecordBatch) -> None:
        tick = component.tick
        if tick == self._agenda.frame:
            self._take_frame(component, into)
        if tick == self._agenda.hash:
            into.hashes.append((tick, hash_row(component, self._state, self._inputs)))
            into.size += 8 * len(self._state)
        if tick == self._agenda.key:
            into.snapshots.append((tick, KEY, component.save()))
            into.size += component.state_bytes

    def _take_frame(self, component: Component, into: RecordBatch) -> None:
        picture = self._track.wants(self._frames)
        balances = component.balance_values()
        values = [balances[name] if name in balances else self._pool.copy(component.peek(name)) for name in self._names]
        into.frames.append((component.tick, values))
        into.size += sum(8 * np.size(value) + 100 for value in values)
        if picture:
            self._track.take(self._frames, self._nanoseconds(component.tick), component, balances)
        self._frames += 1

    def _age(self, tick: int) -> int:
        """Ticks of the whole log, and of its parents, before a tick of this segment."""
        return self._before + tick - self._start_tick

    def _nanoseconds(self, tick: int) -> int:
        return nanoseconds(self._age(tick), self._component.step_size)

    def _note(self, event: str, error: BaseException) -> None:
        tick = self._expected
        content = {"incident": event, "kind": type(error).__name__, "message": str(error)[:4000], "undone_ticks": self._parts}
        self._waiting.append((Record(INCIDENTS, 0, self._segment, tick, tick, 1, 0, content, {}), self._nanoseconds(tick)))

    def _hurry(self) -> None:
        self._wake.set()
        with self._written:
            self._written.wait_for(self._is_keeping_up, _LONGEST_WAIT)

    def _tell_error(self) -> None:
        if self._error is not None:
            self._component.ignore(self)
            raise LogError(
                f"{self._error}. The step itself stands: the component is at {self._component.time:.12g} s, do not "
                "step again. Recording has stopped",
                hint="further steps go on without it",
            ) from self._error

    def _is_keeping_up(self) -> bool:
        behind = perf_counter() > self._due or self._backlog > _WAIT_BYTES
        return not behind or self._error is not None or not self._thread.is_alive()

    # -- the writing thread -----------------------------------------------------------------------------------------

    def _write_header(self, experiment: Any, parent: Any) -> None:
        options = dataclasses.asdict(self._schedule)
        header, arrays = header_of(self._component, self._names, options, experiment, parent, self._elapsed)
        self._digests = {"parameters": parameter_digests(self._component), "header": header_digests(header, arrays)}
        self._sink.add(Record(HEADER, 0, 0, 0, 0, 1, 0, header, arrays), 0)
        self._sink.flush()
        # As it will be read from the log, in the order of that: so a verification finds the same texts.
        self._sink.add_metadata(metadata_of(json.loads(canonical_json(header)), self._component.Parameters))

    def _write_safely(self) -> bool:
        """Write what there is, and at the end the end; return whether that was all."""
        closing = self._closing
        try:
            self._write_gathered()
            if not closing:
                return False
            self._write_end()
        except GranularError as error:
            self._error = error
        except Exception as error:  # the stepping thread has to hear of everything that stops this one
            self._error = LogError(
                f"cannot be written any more: {type(error).__name__}: {error}", source=f"log {str(self.path)!r}"
            )
        finally:
            if self._error is not None:
                self._sink.abandon()
                self._due = 0.0
            with self._written:
                self._written.notify_all()
        self._ended = True
        return True

    def _write_gathered(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
            if self._batch:
                batch = self._batch
                waiting.append(batch)
                self._batch = RecordBatch(batch.segment, batch.last, batch.elapsed)
            self._backlog = sum(item.size for item in waiting if isinstance(item, RecordBatch))
            gathered = perf_counter()
        for item in waiting:
            self._write(item)
        self._sink.flush()
        if any(isinstance(item, RecordBatch) and item.durations for item in waiting):
            self._sink.publish()
        for item in waiting:
            if isinstance(item, RecordBatch):
                self._pool.take_back(value for _, values in item.frames for value in values)
        self._backlog, self._due = 0, gathered + _WAIT_SECONDS
        with self._written:
            self._written.notify_all()

    def _write(self, item: RecordBatch | tuple[Record, int]) -> None:
        if isinstance(item, RecordBatch):
            names = self._names, self._inputs
            write_batch(item, self._sink, self._profiles, *names, self._component.step_size, self._digests)
        else:
            event, time = item
            self._sink.add(dataclasses.replace(event, number=self._sink.number(INCIDENTS)), time)

    def _write_end(self) -> None:
        self._sink.add_preview(self._track.messages())
        arrays = {"index": self._sink.rows}
        place = (self._segment, self._expected, self._expected, 1, self._sink.number(INCIDENTS))
        self._sink.add(Record(INCIDENTS, CLOSED, *place, self._closing_event, arrays), self._nanoseconds(self._expected))
        self._sink.finish()


# Recorders that the end of the program has to close; and their files, which would otherwise be closed before a recorder that
# is collected can write its end.
_OPEN: weakref.WeakSet[Recorder] = weakref.WeakSet()
_FILES: set[LogFile] = set()


@atexit.register
def _close_all() -> None:
    for recorder in list(_OPEN):
        recorder.close()


def _write_on(reference: weakref.ref[Recorder], wake: threading.Event) -> None:
    """Write what a recorder has gathered, until it is closed or gone."""
    done = False
    while not done:
        wake.wait(_WRITE_SECONDS)
        wake.clear()
        recorder = reference()
        done = recorder is None or recorder._write_safely()
        del recorder
