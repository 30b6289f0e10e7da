"""The steps of a log as arrays: how long each was, which inputs it set, and what was held when."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..components.errors import GranularError, LogError
from ..components.inputs import Held
from ..components.profiles import CompiledProfile
from .batch import held_word, set_words
from .format import Record


@dataclass(frozen=True, slots=True)
class Steps:
    """All calls of `step` in one segment.

    Attributes:
        marks: ticks before the first step and after each, shape (steps + 1,).
        sets: for each input that was set at all: the indices of the steps that set it, and the values.
    """

    marks: np.ndarray
    sets: Mapping[str, tuple[np.ndarray, list[Held]]]

    def __len__(self) -> int:
        return len(self.marks) - 1

    def __iter__(self) -> Iterator[tuple[int, dict[str, Held]]]:
        """For each step its length in ticks and the inputs that it set."""
        at = self.by_step()
        for place, ticks in enumerate(np.diff(self.marks).tolist()):
            yield ticks, at.get(place, {})

    def by_step(self) -> dict[int, dict[str, Held]]:
        """Index of the step -> the inputs that it set."""
        found: dict[int, dict[str, Held]] = {}
        for name, (places, values) in self.sets.items():
            for place, value in zip(places.tolist(), values, strict=True):
                found.setdefault(place, {})[name] = value
        return found

    def changes(self, held: Mapping[str, Held]) -> list[tuple[int, dict[str, Held]]]:
        """(tick, inputs) for each step at which the bits of an input really changed, `held` being those at the start."""
        found: dict[int, dict[str, Held]] = {}
        ticks = self.marks
        for name, (places, values) in self.sets.items():
            before: Held | None = held.get(name)
            word = None if before is None else held_word(before)
            for place, value in zip(places.tolist(), values, strict=True):
                if value is before:
                    continue
                new = held_word(value)
                if new != word or isinstance(value, float) != isinstance(before, float):
                    found.setdefault(int(ticks[place]), {})[name] = value
                before, word = value, new
        return sorted(found.items())


def steps_of(
    records: Sequence[Record], start: int, inputs: Sequence[str], profiles: list[CompiledProfile], step_size: float
) -> Steps:
    """The steps in the records of one segment; `profiles` are those of the log so far, and grow."""
    marks = [np.array([start], dtype=np.int64)]
    sets: dict[str, tuple[list[np.ndarray], list[Held]]] = {}
    before = 0
    for record in records:
        durations = _array(record, "durations", np.int64)
        if len(durations) != record.count or (durations < 1).any() or int(durations.sum()) != record.last - record.first:
            raise LogError(f"the steps from tick {record.first} to {record.last} do not add up; the log is damaged")
        _add_profiles(record, inputs, profiles, step_size)
        for name, places, values in _sets_of(record, inputs, profiles):
            parts = sets.setdefault(name, ([], []))
            parts[0].append(places + before)
            parts[1].extend(values)
        marks.append(record.first + np.cumsum(durations))
        before += len(durations)
    return Steps(np.concatenate(marks), {name: (np.concatenate(places), values) for name, (places, values) in sets.items()})


def raw_sets(
    record: Record, inputs: Sequence[str], profile_words: Mapping[int, int]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """What `batch.step_digests` takes, from a record that `steps_of` has found sound."""
    found = {}
    for label, name in enumerate(inputs):
        if f"{label}.steps" in record.arrays:
            places, numbers, values = (record.arrays[f"{label}.{part}"] for part in ("steps", "profiles", "values"))
            found[name] = (places, set_words(numbers, values, profile_words))
    return found


def _sets_of(
    record: Record, inputs: Sequence[str], profiles: list[CompiledProfile]
) -> Iterator[tuple[str, np.ndarray, list[Held]]]:
    for label, name in enumerate(inputs):
        if f"{label}.steps" not in record.arrays:
            continue
        places, numbers = _array(record, f"{label}.steps", np.int64), _array(record, f"{label}.profiles", np.int64)
        values = _array(record, f"{label}.values", np.float64)
        sound = len(places) == len(numbers) == len(values) and np.isfinite(values).all() and len(places)
        if not sound or places[0] < 0 or places[-1] >= record.count or (np.diff(places) <= 0).any():
            raise LogError(f"input {name!r} from tick {record.first} to {record.last} is not what was written")
        if numbers.min() < -1 or numbers.max() >= len(profiles):
            raise LogError(
                f"input {name!r} from tick {record.first} to {record.last} refers to a profile that is not in the log"
            )
        plain = values.tolist()
        yield name, places, [profiles[n] if n >= 0 else plain[i] for i, n in enumerate(numbers.tolist())]


def _users(record: Record, inputs: Sequence[str], number: int) -> str:
    """Which inputs a profile is for, and when, as far as the record still tells."""
    labels = {f"{label}.profiles": name for label, name in enumerate(inputs)}
    names = [name for label, name in labels.items() if label in record.arrays and (record.arrays[label] == number).any()]
    return f"{' and '.join(map(repr, names)) or 'an input'} from tick {record.first} to {record.last}"


def _add_profiles(record: Record, inputs: Sequence[str], profiles: list[CompiledProfile], step_size: float) -> None:
    shapes = _array(record, "profile_shapes", np.int64, 2)
    ticks, coefficients = _array(record, "profile_ticks", np.int64), _array(record, "profile_coefficients", np.float64)
    if record.header.get("profiles_before") != len(profiles):
        raise LogError("profiles of the log are missing, doubled or out of order")
    pieces = number = 0
    for rows, columns in shapes.tolist():
        if rows < 1 or columns < 1 or pieces + rows > len(ticks) or number + rows * columns > len(coefficients):
            raise LogError(f"the profile of {_users(record, inputs, len(profiles))} is not what was written")
        part = coefficients[number : number + rows * columns].reshape(rows, columns)
        try:
            profiles.append(CompiledProfile(step_size, ticks[pieces : pieces + rows], part))
        except GranularError as error:
            users = _users(record, inputs, len(profiles))
            raise LogError(f"the profile of {users} is not what was written: {error}") from error
        pieces, number = pieces + rows, number + rows * columns


def _array(record: Record, name: str, dtype: type, dimensions: int = 1) -> np.ndarray:
    array = record.arrays.get(name)
    if array is None or array.dtype != dtype or array.ndim != dimensions:
        raise LogError(f"a record of steps has no proper {name!r}; the log is damaged")
    return array


def sampled(steps: Steps, start: Mapping[str, Held], name: str, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Ticks and values of one input for plotting: at each change; a profile at its own ticks and in between."""
    places, values = steps.sets.get(name, (np.zeros(0, np.int64), []))
    begins = [int(steps.marks[0]), *steps.marks[places].tolist()]
    held = [start[name], *values]
    ticks, samples = [], []
    for begin, stop, value in zip(begins, [*begins[1:], end], held, strict=True):
        if not isinstance(value, CompiledProfile):
            ticks += [begin, stop]
            samples += [value, value]
        elif stop > begin:
            grid = np.unique(np.concatenate([np.linspace(begin, stop, 201).astype(np.int64), value.ticks, [stop]]))
            grid = grid[(grid >= begin) & (grid <= stop)]
            ticks += grid.tolist()
            samples += [value.value(tick) for tick in grid.tolist()]
    return np.array(ticks, dtype=np.int64), np.array(samples, dtype=np.float64)


def finite_step(value: object) -> float:
    """The log's step size, checked."""
    if not isinstance(value, float) or not math.isfinite(value) or value <= 0.0:
        raise LogError(f"the log's header has step_size {value!r}, expected seconds")
    return value
