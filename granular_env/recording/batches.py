"""Batches: the data that a recorder has collected since it last wrote to the log, and the records made from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from types import NoneType
from typing import Any, NamedTuple

import numpy as np

from ..components.inputs import Held
from ..components.profiles import CompiledProfile
from ..components.snapshot import Snapshot
from .records import END, EVENTS, FRAMES, HASHES, INCIDENTS, KEY, SNAPSHOTS, START, STEPS, Record, to_nanoseconds
from .writer import CHUNK_BYTES, LogWriter

# Number of compiled input profiles that are remembered, so that a profile used by many steps is stored once.
_KNOWN_PROFILES = 256


class Place(NamedTuple):
    """The position of a segment in the log; a segment is a history from a reset or a restore to the next.

    Attributes:
        segment: number of the segment.
        start: first tick of the segment.
        before: number of ticks before the segment, in the log and in the logs from which it was branched.
    """

    segment: int
    start: int
    before: int

    def age(self, tick: int) -> int:
        """Return the number of ticks before a tick of this segment, in the log and in the logs from which it was branched."""
        return self.before + tick - self.start


@dataclass(slots=True)
class Batch:
    """The data of one segment that are written together, or the data taken so far during the current step.

    Attributes:
        place: position of the segment in the log.
        first: tick at which the first step of the batch starts.
        steps: for each step two entries: the tick at its end, and the inputs that it set.
        frames: (tick, list with the value of each recorded variable).
        hashes: (tick, row of hashes from `records.make_hash_row`).
        snapshots: (tick, kind START, KEY or END, snapshot of the state).
        events: rows of events, shape (events, 5) each.
        incidents: (tick, JSON content), for example of a failed step.
        size: approximate size of frames, hashes, snapshots and events [bytes].
    """

    place: Place = Place(-1, 0, 0)
    first: int = 0
    steps: list[Any] = field(default_factory=list)
    frames: list[tuple[int, list[Any]]] = field(default_factory=list)
    hashes: list[tuple[int, np.ndarray]] = field(default_factory=list)
    snapshots: list[tuple[int, int, Snapshot]] = field(default_factory=list)
    events: list[np.ndarray] = field(default_factory=list)
    incidents: list[tuple[int, dict[str, Any]]] = field(default_factory=list)
    size: int = 0

    @property
    def last_tick(self) -> int:
        """Return the tick at which the last step of the batch ends."""
        return self.steps[-2] if self.steps else self.first

    @property
    def is_bare_start(self) -> bool:
        """Return whether the batch contains the start of a segment but no step."""
        return not self.steps and any(why == START for _, why, _ in self.snapshots)

    def add_samples(self, samples: Batch) -> None:
        """Add the frames, hashes, snapshots and events taken during a step."""
        self.frames += samples.frames
        self.hashes += samples.hashes
        self.snapshots += samples.snapshots


class Profiles:
    """The numbers by which steps in the log refer to input profiles; the first `count` profiles are already in the log."""

    def __init__(self, count: int = 0) -> None:
        self._known: dict[int, tuple[CompiledProfile, int]] = {}
        self.count = count
        self._new: list[CompiledProfile] = []

    def profile_number(self, profile: CompiledProfile) -> int:
        """Return the number of a profile; if the profile is new, it gets the next number and is stored with the next batch."""
        known = self._known.get(id(profile))
        if known is None:
            if len(self._known) >= _KNOWN_PROFILES:
                self._known.clear()
            known = self._known[id(profile)] = (profile, self.count)
            self.count += 1
            self._new.append(profile)
        return known[1]

    def new_profiles(self) -> dict[str, np.ndarray]:
        """Return the profiles not yet in the log as concatenated arrays, and the patterns of those with one, by position."""
        profiles, self._new = self._new, []
        patterns = {f"pattern.{place}": p.pattern for place, p in enumerate(profiles) if p.pattern is not None}
        return patterns | {
            "profile_shapes": np.array([p.coefficients.shape for p in profiles], dtype=np.int64).reshape(-1, 2),
            "profile_ticks": np.concatenate([p.ticks for p in profiles] or [np.zeros(0, np.int64)]),
            "profile_coefficients": np.concatenate([p.coefficients.ravel() for p in profiles] or [np.zeros(0)]),
        }


def write_batch(
    batch: Batch,
    writer: LogWriter,
    profiles: Profiles,
    names: list[str],
    inputs: Mapping[str, tuple[int, ...]],
    step_size: float,
) -> None:
    """Write a batch to the log; `names` are the recorded variables, `inputs` the shapes by name, `step_size` is in seconds."""

    def add_record(
        kind: int, detail: int, ticks: Any, arrays: Mapping[str, Any], header: Mapping[str, Any] | None = None
    ) -> None:
        span = int(ticks[0]), int(ticks[-1]), len(ticks)
        record = Record(kind, detail, batch.place.segment, *span, 0, header or {}, arrays)
        writer.add_record(record, to_nanoseconds(batch.place.age(span[1]), step_size))

    def add_snapshots(snapshots: int) -> None:
        for tick, why, snapshot in batch.snapshots:
            if why == snapshots:
                add_record(SNAPSHOTS, why, [tick], {"snapshot": np.frombuffer(snapshot.to_bytes(), np.uint8)})

    add_snapshots(START)
    for variable in range(len(names)):
        values = [np.asarray(frame[variable], dtype=np.float64) for _, frame in batch.frames]
        together = max(1, CHUNK_BYTES // max(values[0].nbytes, 1)) if values else 1
        for begin in range(0, len(values), together):
            ticks = np.array([tick for tick, _ in batch.frames[begin : begin + together]], dtype=np.int64)
            add_record(FRAMES, variable, ticks, {"ticks": ticks, "values": values[begin : begin + together]})
    if batch.events:
        rows = np.concatenate(batch.events)
        add_record(EVENTS, 0, rows[:, 0], {"rows": rows})
    if batch.hashes:
        ticks = np.array([tick for tick, _ in batch.hashes], dtype=np.int64)
        add_record(HASHES, 0, ticks, {"ticks": ticks, "rows": np.stack([row for _, row in batch.hashes])})
    add_snapshots(KEY)
    for tick, content in batch.incidents:
        add_record(INCIDENTS, 0, [tick], {}, content)
    if batch.steps:
        # Write the steps after their frames, hashes and events, so that a truncated file has all of these up to its last step.
        header, arrays = _steps_record(batch, profiles, inputs)
        record = Record(
            STEPS, 0, batch.place.segment, batch.first, batch.last_tick, len(arrays["durations"]), 0, header, arrays
        )
        writer.add_record(record, to_nanoseconds(batch.place.age(batch.last_tick), step_size))
    add_snapshots(END)


def _steps_record(
    batch: Batch, profiles: Profiles, inputs: Mapping[str, tuple[int, ...]]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the header and the arrays of the record that stores the steps of a batch."""
    ends, sets = batch.steps[::2], batch.steps[1::2]
    arrays: dict[str, np.ndarray] = {"durations": np.diff(np.array([batch.first, *ends], dtype=np.int64))}
    # Process each input as a whole: there may be hundreds of thousands of steps per second, and the stepping thread waits.
    for name in dict.fromkeys(chain.from_iterable(sets)):
        values: list[Held | None] = [newly_held.get(name) for newly_held in sets]
        kinds, places = set(map(type, values)), np.arange(len(values))
        if NoneType in kinds:
            places = np.array([place for place, value in enumerate(values) if value is not None], dtype=np.int64)
            values = [value for value in values if value is not None]
        numbers = np.full(len(values), -1)
        if CompiledProfile in kinds:
            for place, value in enumerate(values):
                if isinstance(value, CompiledProfile):
                    numbers[place] = profiles.profile_number(value)
            values = [value for value in values if not isinstance(value, CompiledProfile)]
        label = str(list(inputs).index(name))
        held = np.array(values, dtype=np.float64).reshape(len(values), *inputs[name])
        arrays |= {f"{label}.steps": places, f"{label}.profiles": numbers, f"{label}.values": held}
    arrays |= profiles.new_profiles()
    return {"profiles_before": profiles.count - len(arrays["profile_shapes"])}, arrays
