"""The recorder: an observer that writes the history of a component and never changes it.

The stepping thread appends to a batch in memory. A daemon thread writes the batches every few hundredths of a second, also if
the script is idle, so a killed process loses at most the last tenth of a second.
"""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from time import perf_counter
from typing import Any, Self

import numpy as np

from ..components.component import Component
from ..components.errors import GranularError, LogError, ParameterError, one_line
from ..components.inputs import Held
from .batches import Batch, Place, Profiles, write_batch
from .header import balance_quantities, closing_facts, header_title, make_header, plain_json
from .preview.film import Preview
from .records import END, HEADER, KEY, START, Record, make_hash_row, to_nanoseconds
from .schedule import Schedule, make_schedule, names_to_record, value_count
from .writer import LogWriter, to_path

# Age of collected data at which they are written, and at which a step waits for the writing thread [s]. Otherwise a busy
# stepping thread would starve the writing thread; a kill must lose less than 100 ms.
_WRITE_SECONDS, _WAIT_SECONDS, _LONGEST_WAIT = 0.03, 0.045, 0.5
# Collected bytes at which a part of a long step goes to the queue of the writing thread, and queued bytes at which the
# stepping thread waits.
_WAKE_BYTES, _WAIT_BYTES = 4 << 20, 64 << 20


class Recorder:
    """Recorder of a component, created by `record`; it is a context manager, or is ended by `close`.

    Attributes:
        path: path of the log.
        next_tick: tick at which the next frame, hash or snapshot is due.
    """

    def __init__(
        self,
        component: Component,
        writer: LogWriter,
        names: Sequence[str],
        schedule: Schedule,
        preview: Preview,
        place: Place,
        profiles: int = 0,
        key: int | None = None,
    ) -> None:
        """Start to observe, after the writer has written the header.

        Args:
            component: the component to record.
            writer: writer of the log.
            names: the variables of each frame.
            schedule: times of frames, hashes and snapshots.
            preview: collects the frames that viewers of MCAP files, such as Foxglove, will show.
            place: position of the log's last segment, which a reset ends or which is continued.
            profiles: number of compiled input profiles already in the log.
            key: for a continued segment, the tick of the last snapshot in the log.
        """
        self.path, self.next_tick = writer.path, 0
        self._component, self._names, self._schedule, self._preview = component, list(names), schedule, preview
        self._state = [v.name for v in component.variables.values() if v.state]
        self._inputs = {v.name: v.shape for v in component.variables.values() if v.causality == "input"}
        self._frame_bytes = 8 * value_count(component, self._names) + 100 * (1 + len(self._names))
        self._has_events = bool(component.event_kinds)
        # The next tick for a frame, a hash and a snapshot.
        self._frame = self._hash = self._key = 0
        # Whether each step can be stored unexamined: there are no events, and no array inputs whose size must be counted.
        self._is_plain = not self._has_events and not any(self._inputs.values())
        self._writer, self._profiles, self._continued_key = writer, Profiles(profiles), key
        # The lock protects the queue of batches (the last batch grows) and their total size.
        self._lock, self._wake = threading.Lock(), threading.Event()
        self._written = threading.Condition(self._lock)
        self._batches = [Batch(place=place)]
        self._size = self._backlog = 0
        # The data taken during the current step, and whether a part of the step has already been queued for writing.
        self._samples, self._in_parts = Batch(), False
        self._tick = self._event_count = 0
        self._closing = self._closed = False
        self._error: GranularError | None = None
        self._closing_facts: dict[str, Any] = {}
        self._due = perf_counter() + _WAIT_SECONDS
        try:
            component.observe(self)
        except BaseException:
            writer.abandon()
            raise
        self._thread = threading.Thread(target=self._write_until_closed, name=f"granular-env log {self.path}", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        try:
            self.close()
        except LogError:
            # If the block raised an error, that error is reported instead of one of the log that cannot be written.
            if kind is None:
                raise
        if isinstance(error, GranularError):
            error.add_note(self._log_state_text())

    def _log_state_text(self) -> str:
        """Return a sentence with the path of the log and the time up to which it contains the run."""
        if not self._writer.is_published:
            return f"log: the existing file {str(self.path)!r} is kept"
        if self._error is not None:
            return f"log: {str(self.path)!r} is incomplete; `granular-env recover` completes it"
        end = self._message_time(self._batches[-1].place, self._tick) * 1e-9
        return f"log: {str(self.path)!r} is complete until {end:.9g} s"

    def on_reset(self, component: Component) -> None:
        """Start a new segment, or restart the last segment if it is empty."""
        with self._lock:
            key, self._continued_key = self._continued_key, None
            if key is None:
                self._begin_segment(component)
            else:
                self._continue_segment(component, key)

    def on_sample(self, component: Component) -> None:
        """Take the frame, hash or snapshot due at this tick; if a step has collected much, queue its completed part.

        A step of n ticks equals n steps of one tick, so a part is a valid step. If the rest fails, the component returns to
        the start of the step, which starts a new segment.
        """
        tick, into = component.tick, self._samples
        if not self._closed and self._error is None:
            if tick == self._frame:
                self._store_frame(component, into)
            if tick == self._hash:
                into.hashes.append((tick, make_hash_row(component, self._state, self._inputs)))
                into.size += 8 + 8 * len(self._state)
            if tick == self._key:
                into.snapshots.append((tick, KEY, component.save()))
                into.size += component.state_bytes
            if into.size > _WAKE_BYTES:
                with self._lock:
                    self._store_step(tick, {} if self._in_parts else component.held_inputs)
                    self._in_parts = True
                self._wait_for_writer()
        self._plan_observations(tick)

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Store a completed step; raise `LogError` once if the log cannot be written (the component's step is done)."""
        if self._closed:
            return
        now = component.tick
        with self._lock:
            follows = self._tick == now - ticks
            if follows and self._is_plain and not self._samples.size:
                self._batches[-1].steps.extend((now, inputs))
                self._tick = now
            elif follows or self._in_parts:
                self._store_step(now, {} if self._in_parts else inputs)
                self._in_parts = False
            elif self._tick != now:
                self._begin_segment_after_gap(component)
        if perf_counter() > self._due or self._size > _WAKE_BYTES:
            self._wait_for_writer()
            if self._error is not None:
                component.ignore(self)
                came = (
                    f"{self._error}. Recording has stopped. The step is complete: the component is at {component.time:.12g} s"
                )
                raise LogError(came, hint="do not repeat this step; later steps are not recorded") from self._error

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Discard the data taken during a failed step, except for parts already queued for writing; store the reason."""
        with self._lock:
            undone = max(self._tick - component.tick, 0)
            self._samples, self._in_parts = Batch(), False
            kind = "interrupted" if isinstance(error, KeyboardInterrupt) else "failed"
            self._add_incident(
                {"incident": kind, "kind": type(error).__name__, "message": str(error)[:4000], "undone_ticks": undone}
            )
            if undone:
                self._begin_segment(component)
            else:
                self._plan_observations(component.tick, all_kinds=True)

    def _store_step(self, now: int, inputs: Mapping[str, Held]) -> None:
        batch, samples = self._batches[-1], self._samples
        size = samples.size + sum(value.nbytes for value in inputs.values() if isinstance(value, np.ndarray))
        if now > self._tick:
            batch.steps.extend((now, inputs))
        if self._has_events and (count := self._component.event_count) > self._event_count:
            batch.events.append(self._component.event_rows(self._event_count))
            size += batch.events[-1].nbytes
            self._event_count = count
        batch.add_samples(samples)
        self._tick, self._samples = now, Batch()
        self._size += size

    def _begin_segment(self, component: Component) -> None:
        """Start a segment, or restart the last segment if it contains only its start."""
        tick, last = component.tick, self._batches[-1]
        place = Place(last.place.segment + 1, tick, last.place.age(self._tick))
        incidents: list[Any] = []
        if last.is_bare_start:
            place = last.place._replace(start=tick)
            incidents = self._batches.pop().incidents
        batch = Batch(place=place, first=tick, incidents=incidents)
        batch.snapshots.append((tick, START, component.save()))
        batch.hashes.append((tick, make_hash_row(component, self._state, self._inputs)))
        if self._schedule.next_frame(tick - 1, place.before) == tick:
            self._store_frame(component, batch)
        self._batches.append(batch)
        self._size += component.state_bytes
        self._samples, self._in_parts, self._tick, self._event_count = Batch(), False, tick, component.event_count
        self._plan_observations(tick, all_kinds=True)

    def _begin_segment_after_gap(self, component: Component) -> None:
        """Start a segment because the component has moved unrecorded: a component of which it is a part may have stepped it."""
        first, last = self._tick, component.tick
        times = sorted(tick * component.step_size for tick in (first, last))
        between = "between {:.12g} s and {:.12g} s of the component's time".format(*times)
        self._add_incident({"incident": "unrecorded", "message": f"what happened {between} is not in the log"})
        self._begin_segment(component)

    def _continue_segment(self, component: Component, key: int) -> None:
        """Continue the last segment of the log, after a snapshot at the tick `key`."""
        place, self._tick = self._batches[-1].place, component.tick
        self._batches, self._event_count = [Batch(place=place, first=self._tick)], component.event_count
        self._key = self._schedule.next_snapshot(key, place.age(key))
        self._plan_observations(self._tick)

    def _plan_observations(self, tick: int, all_kinds: bool = False) -> None:
        """Set the next ticks of frame, hash and snapshot: of those due at this tick or, with `all_kinds`, of all three."""
        age, schedule = self._batches[-1].place.age(tick), self._schedule
        if all_kinds or self._frame <= tick:
            self._frame = schedule.next_frame(tick, age)
        if all_kinds or self._hash <= tick:
            self._hash = schedule.next_hash(tick)
        if all_kinds or self._key <= tick:
            self._key = schedule.next_snapshot(tick, age)
        self.next_tick = min(self._frame, self._hash, self._key)

    def _store_frame(self, component: Component, batch: Batch) -> None:
        balances = component.balance_values()
        values = [balances[name] if name in balances else component.peek(name) for name in self._names]
        batch.frames.append((component.tick, [np.array(one) if isinstance(one, np.ndarray) else one for one in values]))
        batch.size += self._frame_bytes

    def _add_incident(self, content: dict[str, Any]) -> None:
        self._batches[-1].incidents.append((self._tick, content))

    def _wait_for_writer(self) -> None:
        """Wake the writing thread, and wait while it is behind."""
        self._wake.set()
        with self._written:
            self._written.wait_for(self._is_keeping_up, _LONGEST_WAIT)

    def _is_keeping_up(self) -> bool:
        return self._error is not None or (perf_counter() <= self._due and self._backlog + self._size <= _WAIT_BYTES)

    def close(self) -> None:
        """Write the remaining data and the summary that completes the file; a second call does nothing.

        Raises:
            LogError: the file could not be written; the message names the path.
        """
        if self._closed:
            return
        if not self._closing:
            self._store_end_state()
            self._component.ignore(self)
            self._closing = True
        self._wake.set()
        self._thread.join()
        self._closed = True
        atexit.unregister(self.close)
        if self._error is not None:
            raise self._error

    def _store_end_state(self) -> None:
        component = self._component
        with self._lock:
            if component.tick != self._tick:
                self._begin_segment_after_gap(component)
            # Make the report before the state is copied, because it takes as much memory.
            self._closing_facts = closing_facts(component)
            batch = self._batches[-1]
            if not batch.is_bare_start:
                batch.snapshots.append((self._tick, END, component.save()))

    def _write_until_closed(self) -> None:
        try:
            closing = False
            while not closing:
                self._wake.wait(_WRITE_SECONDS)
                self._wake.clear()
                closing = self._closing
                self._write_batches()
            place, tick = self._batches[-1].place, self._tick
            self._writer.add_preview(self._preview.messages())
            self._writer.finish(place.segment, tick, self._message_time(place, tick), self._closing_facts)
        except GranularError as error:
            self._error = error
        except Exception as error:  # the stepping thread must learn of any error that stops this thread
            came = f"cannot be written any more: {type(error).__name__}: {error}"
            self._error = LogError(came, source=f"log {str(self.path)!r}")
        finally:
            self._writer.abandon()
            with self._written:
                self._due = 0.0 if self._error is not None else self._due
                self._written.notify_all()

    def _write_batches(self) -> None:
        with self._lock:
            batches, gathered = self._batches, perf_counter()
            self._batches = [Batch(place=batches[-1].place, first=batches[-1].last_tick)]
            self._backlog, self._size = self._size, 0
        for batch in batches:
            write_batch(batch, self._writer, self._profiles, self._names, self._inputs, self._component.step_size)
            for tick, values in batch.frames:
                self._preview.add_frame(self._message_time(batch.place, tick), dict(zip(self._names, values, strict=True)))
        self._writer.flush()
        if any(batch.steps for batch in batches):
            self._writer.publish()
        with self._written:
            self._backlog, self._due = 0, gathered + _WAIT_SECONDS
            self._written.notify_all()

    def _message_time(self, place: Place, tick: int) -> int:
        return to_nanoseconds(place.age(tick), self._component.step_size)


def record(
    component: Component,
    path: str | os.PathLike[str],
    *,
    every: float | None = None,
    variables: Sequence[str] | None = None,
    hash_every: int | None = None,
    snapshot_every: float | None = None,
    experiment: Mapping[str, Any] | None = None,
    overwrite: bool = False,
) -> Recorder:
    """Record `component` from now until the recorder is closed.

        with ge.record(chain, "logs/mine.mcap", every=1e-6, variables=["velocity"]):
            chain.reset(velocity={0: 5.0})
            chain.step(1e-4)

    All inputs and the start state are stored exactly, so that the log can be run again; frames are for display.

    Args:
        component: the component to record.
        path: the file; by convention it ends in ``.mcap``.
        every: time between frames [s], a whole number of ticks. Default: 160 to 400 frames for an experiment with a
            duration; otherwise every tick at first, with the interval doubled each time the run has doubled in length.
        variables: names of outputs or inputs for each frame, in addition to the balances and scalar inputs. Default: the
            state variables, the outputs drawn by viewers, and all scalar outputs.
        hash_every: ticks between hashes of the state; with 1, a verification can name the exact step. Default: 4096.
        snapshot_every: time between snapshots [s]. Default: each time the run is longer by a sixteenth, at least 4096 ticks
            apart; fewer ticks if a tick is costly because of a large state or many steps of a part.
        experiment: JSON values to store in the log.
        overwrite: whether an existing log may be replaced; it is kept until the new log contains its first step.

    Raises:
        ParameterError: an argument is invalid, or the file exists, is not a log, or is being written by another recorder;
            nothing has been written.
        LogError: the file cannot be written.
    """
    if not isinstance(component, Component):
        raise ParameterError(f"got {one_line(component)}", expected="a component", at="component")
    target = to_path(path)
    names = names_to_record(component, variables)
    schedule = make_schedule(component, every, hash_every, snapshot_every, experiment, names)
    content = plain_json("experiment", experiment)
    return begin_log(component, LogWriter(target, overwrite), names, schedule, content)


def begin_log(
    component: Component,
    writer: LogWriter,
    names: list[str],
    schedule: Schedule,
    experiment: Any = None,
    parent: Any = None,
    elapsed: int = 0,
) -> Recorder:
    """Write the header of a log, and return its recorder; a branch has a `parent` and `elapsed` ticks before its start."""
    try:
        header, arrays = make_header(component, names, asdict(schedule), experiment, parent, elapsed)
        writer.add_header(Record(HEADER, 0, 0, 0, 0, 1, 0, header, arrays))
        variables = {name: component.variables[name] for name in names}
        preview = Preview(header_title(header), component.drawables(), variables, balance_quantities(header["balances"]))
    except BaseException:
        writer.abandon()
        raise
    return Recorder(component, writer, names, schedule, preview, Place(-1, 0, elapsed))
