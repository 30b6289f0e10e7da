"""The recorder: an observer that writes what a component does, without ever changing it.

The stepping thread only appends to lists. One daemon thread does all the writing, every few hundredths of a second, also
while the script sits idle: so a killed process loses at most the last tenth of a second, and Ctrl-C never cuts a write.
"""

from __future__ import annotations

import atexit
import json
import threading
import warnings
import weakref
from collections.abc import Mapping
from contextlib import suppress
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ...components.component import Component
from ...components.errors import GranularError, LogError, ParameterError
from ...components.inputs import Held
from ...components.support.serialization import canonical_json
from ..format.digests import hash_row, header_digests, parameter_digests
from ..format.header import closing_facts, header_of
from ..format.metadata import metadata_of, title_of
from ..format.records import CLOSED, HEADER, INCIDENTS, KEY, START, Record, nanoseconds
from ..preview.frame_selection import FROM_FRAMES, PreviewFrames, facts_of
from .buffer_pool import BufferPool
from .history_items import End, Item, Place, PlainSteps, Start, Step, batches_of, empty_batch, without_snapshot
from .log_file import LogFile
from .log_writer import LogWriter
from .pending_data import Profiles, RecordBatch, Samples, write_batch
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
        self._has_events, self._agenda = bool(component.event_kinds), Agenda(schedule)
        # Whether a step like the last need not be looked at: no events, and no inputs that are arrays, whose size counts.
        self._is_plain = not self._has_events and not any(self._inputs.values())
        # Locks and queues of C: an interrupt inside `Condition` or `Event`, which are Python, leaves them locked for ever.
        self._lock, self._wake, self._written = threading.Lock(), SimpleQueue[None](), SimpleQueue[None]()
        self._closing = self._closed = self._ended = False
        # What has been noted since the last write, about how many bytes that is, and the last item before it.
        self._items, self._size = list[Item](), 0
        self._elapsed = elapsed
        self._written_item: Item = Start(Place(-1, 0, elapsed), 0, 0, 0, Samples())
        self._incidents = list[tuple[Place, int, dict[str, Any]]]()
        self._samples = Samples()  # of the step under way
        # Tick up to which the step under way has been noted; -1 where no part of it has.
        self._part_until = -1
        self._backlog = 0  # bytes being written
        self._error: GranularError | None = None
        self._continuation, self._preview_facts = continuation, {}
        self._preview = PreviewFrames(facts_of(component, title_of({"experiment": experiment, "component": component.name})))
        self._profiles = Profiles()
        self._batch = RecordBatch(-1, 0, 0)  # what the writing thread goes on with
        self._pool = BufferPool()
        self._file, self._sink = file, LogWriter(path, file)
        try:
            if continuation is None:
                self._write_header(experiment, parent)
            else:
                continuation.copy_to(self._sink)
            self._due = perf_counter() + _WAIT_SECONDS
            component.observe(self)
        except BaseException:
            self._sink.abandon()
            raise
        # The thread knows it weakly: a recorder that nobody holds any more, nor the component, is closed and collected.
        # Something is in it once the thread is done. Python takes a thread for ended whose `join` was interrupted.
        self._gone = list[bool]()
        end = self._gone, self._written
        self._thread = threading.Thread(
            target=_write_on, args=(weakref.ref(self), self._wake, *end), name=f"granular-env log {path}", daemon=True
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
            self._look(component, self._samples)
            # By size alone: what a log holds must not depend on how fast the machine was.
            if self._samples.size > _WAKE_BYTES:
                self._take_part(component)
        self.next_tick = self._agenda.after(component.tick, self._last.place.age(component.tick))

    def _take_part(self, component: Component) -> None:
        with self._lock:
            last, now = self._last.tick, component.tick
            is_first = last != self._part_until
            if is_first and last != component.step_start:
                self._begin_after_gap(component)
            else:
                self._take_step(now, component.held_inputs if is_first else {})
            self._part_until = now
        self._hurry()

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Note a whole step; raises `LogError` once if the log cannot be written, with the component's step done."""
        if self._closed:
            return
        now = component.tick
        with self._lock:
            last = self._items[-1] if self._items else self._written_item
            if type(last) is PlainSteps and self._is_plain and last.tick == now - ticks and not self._samples.size:
                last.flat.extend((now, inputs))  # as usual, and as `_take_step` does
            else:
                self._take_whole_step(component, last.tick, now - ticks, inputs)
        if perf_counter() > self._due or self._size > _WAKE_BYTES:
            self._hurry()
            self._tell_error()

    def _take_whole_step(self, component: Component, last: int, start: int, inputs: Mapping[str, Held]) -> None:
        """Note a step in which there was something to be seen, or that has been noted in part, or after a gap."""
        now, is_first = component.tick, self._part_until < 0
        self._part_until = -1
        if last == now:  # all of it has been noted: in parts, or before it was told of once more
            self._samples = Samples()
        elif is_first and last != start:
            self._begin_after_gap(component)
        else:
            self._take_step(now, inputs if is_first else {})

    @property
    def _last(self) -> Item:
        """The last item of the history: it tells where that stands."""
        items = self._items  # the writing thread may put another list in its place
        return items[-1] if items else self._written_item

    def _take_step(self, now: int, inputs: Mapping[str, Held]) -> None:
        last, samples, rows = self._last, self._samples or None, None
        frames, events, size = last.frames, last.events, _STEP_BYTES
        for value in inputs.values():
            size += _SET_BYTES + (value.nbytes if isinstance(value, np.ndarray) else 0)
        if self._has_events and self._component.event_count > events:
            rows = self._component.event_rows(events)
            _refuse_other_ticks(rows, last.tick, now)
            events += len(rows)
            size += rows.nbytes
        if samples is not None:
            frames, size = frames + len(samples.frames), size + samples.size
        # Each in one operation: see `history_items`.
        if samples is not None or rows is not None:
            self._items.append(Step(last.place, now, frames, events, inputs, samples, rows))
            self._samples = Samples()
        elif isinstance(last, PlainSteps):
            last.flat.extend((now, inputs))
        else:
            self._items.append(PlainSteps(last.place, frames, events, [now, inputs]))
        self._size += size

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Forget what was seen inside the step that failed, unless its parts were handed over; keep the reason."""
        with self._lock:
            last, self._samples, self._part_until = self._last, Samples(), -1
            self._preview.forget_from(last.frames)
            undone = max(last.tick - component.tick, 0)
            kind = "interrupted" if isinstance(error, KeyboardInterrupt) else "failed"
            self._note({"incident": kind, "kind": type(error).__name__, "message": str(error)[:4000], "undone_ticks": undone})
            if undone:
                self._begin(component)
            else:
                self.next_tick = self._agenda.restart(component.tick, last.place.age(component.tick))

    # -- the end ----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Write the rest and the summary that makes the file complete; a second call does nothing.

        Raises:
            LogError: something could not be written; the path is named.
        """
        if self._closed:
            return
        if not self._closing:
            self._finish()
            self._component.ignore(self)
            self._closing = True
        _signal(self._wake)
        # The collector of garbage may run in any thread.
        if threading.current_thread() is not self._thread:
            while not self._gone:
                _wait(self._written, _WRITE_SECONDS)
        if not self._ended:
            # It is being collected, and the thread, which knew it weakly, has gone.
            self._write_safely()
        self._closed = True
        _OPEN.discard(self)
        _FILES.discard(self._file)
        if self._error is not None:
            raise self._error

    def _finish(self) -> None:
        """Note the end of the history."""
        with self._lock:
            component = self._component
            if component.tick != self._last.tick:
                self._begin_after_gap(component)
            # Before the state is copied once more: to draw them up takes as much memory.
            facts = closing_facts(component)
            last = self._last
            if not isinstance(last, End) and not (self._items and isinstance(last, Start)):
                self._items.append(End(last.place, last.tick, last.frames, last.events, component.save()))
            preview = {**self._preview_facts, "stride": self._preview.stride}
            self._closing_event = {"incident": "closed", "preview": preview, **facts}

    # -- inside the stepping thread ---------------------------------------------------------------------------------

    def _begin(self, component: Component) -> None:
        """Note the start of a segment. The last one is begun anew where nothing but its start has been noted of it."""
        tick, last, samples = component.tick, self._last, Samples()
        self._samples, self._part_until = Samples(), -1
        is_anew = bool(self._items) and isinstance(last, Start)
        place = Place(last.place.segment, tick, last.place.before)
        if not is_anew:
            place = Place(last.place.segment + 1, tick, last.place.age(last.tick))
        frames = last.frames - len(last.samples.frames) if isinstance(last, Start) and is_anew else last.frames
        # What was seen inside a step that is not recorded is forgotten.
        self._preview.forget_from(frames)
        samples.snapshots.append((tick, START, component.save()))
        samples.size += component.state_bytes
        if self._has_events and tick > 0:
            samples.earlier_events = component.event_rows()
        samples.hashes.append((tick, hash_row(component, self._state, self._inputs)))
        if self._schedule.is_frame(tick, place.before):
            self._take_frame(component, samples, frames, place)
        start = Start(place, tick, frames + len(samples.frames), component.event_count, samples)
        if is_anew:
            self._items[-1] = start
        else:
            self._items.append(start)
            self._size += samples.size
        self.next_tick = self._agenda.restart(tick, place.before)

    def _begin_after_gap(self, component: Component) -> None:
        """Begin a segment where the component is not where the last step that was told of has left it; keep that.

        So it is where a second interrupt cut the telling of the first one's step, or where a parent has stepped it.
        """
        first, last = self._last.tick, component.tick
        times = sorted(tick * component.step_size for tick in (first, last))
        between = "between {:.12g} s and {:.12g} s of the component's time".format(*times)
        what = f"what happened {between} is not in the log"
        self._note({"incident": "unrecorded", "message": what, "first_tick": first, "last_tick": last})
        self._begin(component)

    def _go_on(self, component: Component, kept: Continuation) -> None:
        """Take the place of the recorder that wrote what is kept of a log."""
        tick, place = component.tick, Place(0, kept.start, self._written_item.place.before)
        self._written_item = Start(place, tick, kept.frames, component.event_count, Samples())
        self._batch = empty_batch(place, tick)
        # What the preview shows beside the recorded variables is lost with the process that recorded them.
        self._preview, self._preview_facts = kept.preview(), FROM_FRAMES
        self._profiles.count, self._digests = kept.profiles, {}
        self._agenda.key = self._schedule.key_after(kept.key, place.age(kept.key))
        self.next_tick = self._agenda.after(tick, place.age(tick))

    def _look(self, component: Component, into: Samples) -> None:
        tick, last = component.tick, self._last
        if tick == self._agenda.frame:
            self._take_frame(component, into, last.frames + len(into.frames), last.place)
        if tick == self._agenda.hash:
            into.hashes.append((tick, hash_row(component, self._state, self._inputs)))
            into.size += 8 + 8 * len(self._state)
        if tick == self._agenda.key:
            into.snapshots.append((tick, KEY, component.save()))
            into.size += component.state_bytes

    def _take_frame(self, component: Component, into: Samples, number: int, place: Place) -> None:
        balances = component.balance_values()
        values = [balances[name] if name in balances else self._pool.copy(component.peek(name)) for name in self._names]
        if self._preview.wants(number):
            time = nanoseconds(place.age(component.tick), component.step_size)
            self._preview.take(number, time, component, balances)
        into.size += 100 + sum(8 * np.size(value) + 100 for value in values)
        into.frames.append((component.tick, values))

    def _note(self, content: dict[str, Any]) -> None:
        last = self._last
        self._incidents.append((last.place, last.tick, content))

    def _hurry(self) -> None:
        _signal(self._wake)
        end = perf_counter() + _LONGEST_WAIT
        while not self._is_keeping_up() and (left := end - perf_counter()) > 0.0:
            _wait(self._written, left)

    def _tell_error(self) -> None:
        if self._error is not None:
            self._component.ignore(self)
            raise LogError(
                f"{self._error}. Recording has stopped. The step is complete: the component is at "
                f"{self._component.time:.12g} s",
                hint="do not repeat this step; later steps are not recorded",
            ) from self._error

    def _is_keeping_up(self) -> bool:
        behind = perf_counter() > self._due or self._backlog > _WAIT_BYTES
        return not behind or self._error is not None or bool(self._gone)

    # -- the writing thread -----------------------------------------------------------------------------------------

    def _write_header(self, experiment: Any, parent: Any) -> None:
        options = self._schedule.options()
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
            _signal(self._written)
        self._ended = True
        return True

    def _write_gathered(self) -> None:
        with self._lock:
            items, incidents, gathered = self._items, self._incidents, perf_counter()
            self._written_item = without_snapshot(self._last)
            self._items, self._incidents = [], []
            self._backlog, self._size = self._size, 0
        batches = batches_of(items, self._batch)
        for batch in batches:
            names = self._names, self._inputs
            write_batch(batch, self._sink, self._profiles, *names, self._component.step_size, self._digests)
        for place, tick, content in incidents:
            self._write_incident(place, tick, content)
        self._sink.flush()
        if any(batch.ends for batch in batches):
            self._sink.publish()
        self._pool.take_back(value for batch in batches for _, values in batch.frames for value in values)
        self._batch = empty_batch(self._written_item.place, self._written_item.tick)
        self._backlog, self._due = 0, gathered + _WAIT_SECONDS
        _signal(self._written)

    def _write_incident(self, place: Place, tick: int, content: dict[str, Any]) -> None:
        record = Record(INCIDENTS, 0, place.segment, tick, tick, 1, self._sink.number(INCIDENTS), content, {})
        self._sink.add(record, nanoseconds(place.age(tick), self._component.step_size))

    def _write_end(self) -> None:
        self._sink.add_preview(self._preview.messages())
        place, tick = self._written_item.place, self._written_item.tick
        row = (place.segment, tick, tick, 1, self._sink.number(INCIDENTS))
        time = nanoseconds(place.age(tick), self._component.step_size)
        self._sink.add(Record(INCIDENTS, CLOSED, *row, self._closing_event, {"index": self._sink.rows}), time)
        self._sink.finish()


# Recorders that the end of the program has to close; and their files, which would otherwise be closed before a recorder that
# is collected can write its end.
_OPEN: weakref.WeakSet[Recorder] = weakref.WeakSet()
_FILES: set[LogFile] = set()


@atexit.register
def _close_all() -> None:
    for recorder in list(_OPEN):
        while not recorder._closed:
            # The log is made complete: another Ctrl-C would leave half of its end.
            with suppress(KeyboardInterrupt):
                recorder.close()


def _refuse_other_ticks(events: np.ndarray, first: int, last: int) -> None:
    """Refuse events of other ticks than those of the step: no log can hold them."""
    strange = events[(events[:, 0] < first) | (events[:, 0] > last), 0]
    if len(strange):
        raise ParameterError(
            f"the component noted one for tick {strange[0]:.0f}",
            expected=f"ticks of the step, {first + 1} to {last}",
            at="event",
        )


def _signal(queue: SimpleQueue[None]) -> None:
    """Let whoever waits for a queue go on."""
    if queue.empty():
        queue.put(None)


def _wait(queue: SimpleQueue[None], seconds: float) -> None:
    """Wait for a signal, so long at most."""
    with suppress(Empty):
        queue.get(timeout=seconds)


def _write_on(reference: weakref.ref[Recorder], wake: SimpleQueue[None], gone: list[bool], written: SimpleQueue[None]) -> None:
    """Write what a recorder has gathered, until it is closed or gone."""
    done = False
    try:
        while not done:
            _wait(wake, _WRITE_SECONDS)
            recorder = reference()
            done = recorder is None or recorder._write_safely()
            del recorder
    finally:
        gone.append(True)
        _signal(written)
