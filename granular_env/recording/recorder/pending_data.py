"""The data that a recorder has gathered since it last wrote, and how they become records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from types import NoneType
from typing import Any

import numpy as np

from ...components.inputs import Held
from ...components.profiles import CompiledProfile
from ...components.snapshot import Snapshot
from ...components.support.serialization import Pieces
from ..format.digests import held_word, set_words, step_digests
from ..format.records import EVENTS, FRAMES, HASHES, SNAPSHOTS, START, STEPS, Record, nanoseconds
from .log_writer import CHUNK_BYTES, LogWriter

# Compiled profiles that are remembered by object, so that one that is used again is stored once.
_KNOWN_PROFILES = 256


@dataclass(slots=True)
class Samples:
    """Observations at some ticks.

    Attributes:
        frames: (tick, one value for each recorded variable).
        hashes: (tick, one row).
        snapshots: (tick, START or KEY, snapshot).
        earlier_events: at the start of a segment after tick 0, the events that the component has had; else None.
        size: bytes, about; 0 where nothing was seen.
    """

    frames: list[tuple[int, list[Any]]] = field(default_factory=list)
    hashes: list[tuple[int, np.ndarray]] = field(default_factory=list)
    snapshots: list[tuple[int, int, Snapshot]] = field(default_factory=list)
    earlier_events: np.ndarray | None = None
    size: int = 0

    def __bool__(self) -> bool:
        return bool(self.frames or self.hashes or self.snapshots)


@dataclass(slots=True)
class RecordBatch:
    """Everything of one segment between two writes.

    Attributes:
        segment: which segment.
        first: tick before the first step.
        elapsed: ticks of the whole log before this segment, minus the segment's first tick.
        ends: the tick after each step.
        inputs: those that each step set, by name.
        frames: (tick, one value for each recorded variable).
        hashes: (tick, one row).
        events: rows of events, shape (events, 5) each.
        snapshots: (tick, START, KEY or END, snapshot).
        earlier_events: see `Samples`.
    """

    segment: int
    first: int
    elapsed: int
    ends: list[int] = field(default_factory=list)
    inputs: list[Mapping[str, Held]] = field(default_factory=list)
    frames: list[tuple[int, list[Any]]] = field(default_factory=list)
    hashes: list[tuple[int, np.ndarray]] = field(default_factory=list)
    events: list[np.ndarray] = field(default_factory=list)
    snapshots: list[tuple[int, int, Snapshot]] = field(default_factory=list)
    earlier_events: np.ndarray | None = None

    @property
    def last(self) -> int:
        """Return the tick after the last step."""
        return self.ends[-1] if self.ends else self.first

    def take(self, samples: Samples) -> None:
        """Add what was seen at the start, or in a step."""
        self.frames += samples.frames
        self.hashes += samples.hashes
        self.snapshots += samples.snapshots
        if samples.earlier_events is not None:
            self.earlier_events = samples.earlier_events


class Profiles:
    """Numbers for compiled profiles: the same object gets the same number while it is remembered."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[CompiledProfile, int, int]] = {}
        self.count = 0
        self._new: list[CompiledProfile] = []

    def number(self, profile: CompiledProfile) -> tuple[int, int]:
        """Return a profile's number and its `held_word`; a new one is stored with the next batch."""
        known = self._known.pop(id(profile), None)
        if known is None:
            known = (profile, self.count, held_word(profile))
            self.count += 1
            self._new.append(profile)
            if len(self._known) >= _KNOWN_PROFILES:
                self._known.pop(next(iter(self._known)))
        self._known[id(profile)] = known
        return known[1:]

    def new(self) -> dict[str, np.ndarray]:
        """Return the profiles not stored yet, end to end, and the pattern of each that has one, by its position."""
        profiles, self._new = self._new, []
        patterns = {f"pattern.{place}": p.pattern for place, p in enumerate(profiles) if p.pattern is not None}
        return patterns | {
            "profile_shapes": np.array([p.coefficients.shape for p in profiles], dtype=np.int64).reshape(-1, 2),
            "profile_ticks": np.concatenate([p.ticks for p in profiles] or [np.zeros(0, np.int64)]),
            "profile_coefficients": np.concatenate([p.coefficients.ravel() for p in profiles] or [np.zeros(0)]),
        }


def write_batch(
    batch: RecordBatch,
    sink: LogWriter,
    profiles: Profiles,
    names: list[str],
    inputs: Mapping[str, tuple[int, ...]],
    step_size: float,
    digests: Mapping[str, Any],
) -> None:
    """Write all that a batch holds; where a segment starts also the digests of parameters and header."""
    for record in _records(batch, sink, profiles, names, inputs, digests):
        sink.add(record, nanoseconds(batch.elapsed + record.last, step_size))


def _records(
    batch: RecordBatch,
    sink: LogWriter,
    profiles: Profiles,
    names: list[str],
    inputs: Mapping[str, tuple[int, ...]],
    digests: Mapping[str, Any],
) -> Iterator[Record]:
    starts = [item for item in batch.snapshots if item[1] == START]
    yield from _snapshots(batch, sink, starts)
    if batch.ends:
        yield from _steps(batch, sink, profiles, inputs)
    if batch.frames:
        yield from _frames(batch, sink, names)
    if batch.events:
        rows = np.concatenate(batch.events)
        place = (batch.segment, int(rows[0, 0]), int(rows[-1, 0]), len(rows))
        yield Record(EVENTS, 0, *place, sink.number(EVENTS), {}, {"rows": rows})
    if batch.hashes:
        ticks = np.array([tick for tick, _ in batch.hashes], dtype=np.int64)
        arrays = {"ticks": ticks, "rows": np.stack([row for _, row in batch.hashes])}
        place = (batch.segment, int(ticks[0]), int(ticks[-1]), len(ticks))
        yield Record(HASHES, 0, *place, sink.number(HASHES), dict(digests) if starts else {}, arrays)
    yield from _snapshots(batch, sink, [item for item in batch.snapshots if item[1] != START])


def _snapshots(batch: RecordBatch, sink: LogWriter, items: list[tuple[int, int, Snapshot]]) -> Iterator[Record]:
    for tick, why, snapshot in items:
        arrays: dict[str, Any] = {"snapshot": Pieces(snapshot.to_parts())}
        if why == START and batch.earlier_events is not None:
            # The state holds them too, but only its component can find them there.
            arrays["events"] = batch.earlier_events
        yield Record(SNAPSHOTS, why, batch.segment, tick, tick, 1, sink.number(SNAPSHOTS), {}, arrays)


def _steps(batch: RecordBatch, sink: LogWriter, profiles: Profiles, inputs: Mapping[str, tuple[int, ...]]) -> Iterator[Record]:
    durations = np.diff(np.array([batch.first, *batch.ends], dtype=np.int64))
    profile_words: dict[int, int] = {}
    arrays = {"durations": durations}
    content = {}
    for name, (places, numbers, held) in _by_name(batch.inputs, profiles, profile_words).items():
        values = np.array(held, dtype=np.float64).reshape(len(held), *inputs[name])
        content[name] = (places, set_words(numbers, values, profile_words))
        label = str(list(inputs).index(name))
        arrays |= {f"{label}.steps": places, f"{label}.profiles": numbers, f"{label}.values": values}
    arrays |= profiles.new()
    header = {"profiles_before": profiles.count - len(arrays["profile_shapes"])}
    place = (batch.segment, batch.first, batch.last, len(durations))
    yield Record(STEPS, 0, *place, sink.number(STEPS), header, arrays)
    # A second account of the inputs, apart from the first: a changed one does not go unnoticed even where rounding hides it.
    yield Record(HASHES, 1, *place, sink.number(HASHES), {"steps": step_digests(durations, content)}, {})


def _by_name(
    inputs: list[Mapping[str, Held]], profiles: Profiles, profile_words: dict[int, int]
) -> dict[str, tuple[np.ndarray, np.ndarray, list[Any]]]:
    """Return for each input that was set: at which steps, the numbers of profiles (-1 for none), and the other values."""
    found = {}
    # As wholes: there may be hundreds of thousands of steps a second, and the stepping thread waits for this one.
    for name in dict.fromkeys(chain.from_iterable(inputs)):
        values: list[Any] = [newly_held.get(name) for newly_held in inputs]
        kinds, places = set(map(type, values)), np.arange(len(values))
        if NoneType in kinds:
            places = np.array([place for place, value in enumerate(values) if value is not None], dtype=np.int64)
            values = [value for value in values if value is not None]
        numbers = np.full(len(values), -1)
        if CompiledProfile in kinds:
            for place, value in enumerate(values):
                if isinstance(value, CompiledProfile):
                    numbers[place], profile_words[numbers[place]] = profiles.number(value)
            values = [value for value in values if not isinstance(value, CompiledProfile)]
        found[name] = (places, numbers, values)
    return found


def _frames(batch: RecordBatch, sink: LogWriter, names: list[str]) -> Iterator[Record]:
    for variable in range(len(names)):
        values = [np.asarray(frame[variable], dtype=np.float64) for _, frame in batch.frames]
        together = max(1, CHUNK_BYTES // max(values[0].nbytes, 1))
        for begin in range(0, len(values), together):
            ticks = np.array([tick for tick, _ in batch.frames[begin : begin + together]], dtype=np.int64)
            arrays = {"ticks": ticks, "values": _stack(values[begin : begin + together])}
            place = (batch.segment, int(ticks[0]), int(ticks[-1]), len(ticks))
            yield Record(FRAMES, variable, *place, sink.number(FRAMES), {}, arrays)


def _stack(values: list[np.ndarray]) -> np.ndarray:
    """One array of all; a single large frame is not copied."""
    return values[0][np.newaxis] if len(values) == 1 else np.stack(values)
