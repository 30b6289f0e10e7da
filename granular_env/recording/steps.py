"""The calls of `step` in a log as arrays: their lengths, the inputs they set, and the intervals between input changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..components.errors import GranularError, LogError
from ..components.inputs import Held, input_value, make_read_only
from ..components.profiles import CompiledProfile
from .records import Record, damage_error, input_word

# Number of samples of a profile over the interval in which it is in effect, in addition to its breakpoints.
_PROFILE_SAMPLES = 201
# Number of further samples in each curved piece of a profile; even, so that one falls on the peak of a half sine.
_PIECE_SAMPLES = 32


@dataclass(frozen=True, slots=True)
class StepHistory:
    """All calls of `step` in a segment.

    Attributes:
        marks: ticks before the first step and after each, shape (steps + 1,).
        sets: for each input that was set, the indices of the steps that set it, and the values.
    """

    marks: np.ndarray
    sets: Mapping[str, tuple[np.ndarray, list[Held]]]

    def __len__(self) -> int:
        return len(self.marks) - 1

    def __iter__(self) -> Iterator[tuple[int, dict[str, Held]]]:
        """Yield the length in ticks and the set inputs of each step."""
        found: list[dict[str, Held]] = [{} for _ in range(len(self))]
        for name, (places, values) in self.sets.items():
            for place, value in zip(places.tolist(), values, strict=True):
                found[place][name] = value
        return zip(np.diff(self.marks).tolist(), found, strict=True)

    def input_changes(self, start_inputs: Mapping[str, Held]) -> list[tuple[int, dict[str, Held]]]:
        """Return (tick, inputs) for each step that changed the bits of an input after the start of the segment."""
        found: dict[int, dict[str, Held]] = {}
        for name, (places, values) in self.sets.items():
            before: Held | None = start_inputs.get(name)
            bits = None if before is None else _bit_key(before)
            for tick, value in zip(self.marks[places].tolist(), values, strict=True):
                if value is not before:
                    new = _bit_key(value)
                    if new != bits:
                        found.setdefault(tick, {})[name] = value
                    before, bits = value, new
        return sorted(found.items())


def _bit_key(value: Held) -> Any:
    """Return a hashable key of an input's value, equal only for equal bits; a non-zero number is its own key."""
    return value if type(value) is float and value else (type(value), input_word(value))


def parse_steps(
    records: Sequence[Record],
    start: int,
    inputs: Mapping[str, tuple[int, ...]],
    profiles: list[CompiledProfile],
    step_size: float,
) -> StepHistory:
    """Return the steps in the records of a segment that starts at tick `start`; append to the log's `profiles`.

    `inputs` are the shapes of the component's inputs by name; `step_size` is the length of a tick [s].
    """
    marks = [np.array([start], dtype=np.int64)]
    sets: dict[str, tuple[list[np.ndarray], list[Held]]] = {}
    before = 0
    for record in records:
        durations = _record_array(record, "durations", np.int64)
        if len(durations) != record.count or (durations < 1).any() or int(durations.sum()) != record.last - record.first:
            raise damage_error(f"the steps from tick {record.first} to {record.last} do not add up to this interval", "steps")
        _add_profiles(record, profiles, step_size)
        for name, places, values in _parse_inputs(record, inputs, profiles):
            parts = sets.setdefault(name, ([], []))
            parts[0].append(places + before)
            parts[1].extend(values)
        marks.append(record.first + np.cumsum(durations))
        before += len(durations)
    joined = {name: (np.concatenate(places), values) for name, (places, values) in sets.items()}
    return StepHistory(np.concatenate(marks), joined)


def _parse_inputs(
    record: Record, inputs: Mapping[str, tuple[int, ...]], profiles: list[CompiledProfile]
) -> Iterator[tuple[str, np.ndarray, list[Held]]]:
    span = f"from tick {record.first} to {record.last}"
    for label, (name, shape) in enumerate(inputs.items()):
        if f"{label}.steps" not in record.arrays:
            continue
        places = _record_array(record, f"{label}.steps", np.int64)
        numbers = _record_array(record, f"{label}.profiles", np.int64)
        values = _record_array(record, f"{label}.values", np.float64, 1 + len(shape))
        sound = len(places) == len(numbers) > 0 and len(values) == (numbers < 0).sum() and values.shape[1:] == shape
        sound = sound and np.isfinite(values).all() and (np.diff(places) > 0).all() and 0 <= places[0]
        sound = sound and places[-1] < record.count and numbers.min() >= -1 and numbers.max() < len(profiles)
        if not sound or any(profiles[number].shape != shape for number in set(numbers.tolist()) if number >= 0):
            raise damage_error(f"the input {span} is invalid", ("steps", name))
        plain = iter(values.tolist() if shape == () else [make_read_only(value.copy()) for value in values])
        yield name, places, [profiles[number] if number >= 0 else next(plain) for number in numbers.tolist()]


def _add_profiles(record: Record, profiles: list[CompiledProfile], step_size: float) -> None:
    shapes = _record_array(record, "profile_shapes", np.int64, 2)
    ticks = _record_array(record, "profile_ticks", np.int64)
    coefficients = _record_array(record, "profile_coefficients", np.float64)
    if record.header.get("profiles_before") != len(profiles):
        raise damage_error("profiles are missing, duplicated or out of order", "steps")
    pieces = number = 0
    for place, (rows, columns) in enumerate(shapes.tolist()):
        if rows < 1 or columns < 1 or pieces + rows > len(ticks) or number + rows * columns > len(coefficients):
            raise damage_error(f"profile {len(profiles)} is invalid", "steps")
        part = coefficients[number : number + rows * columns].reshape(rows, columns)
        try:
            pattern = record.arrays.get(f"pattern.{place}")
            if pattern is not None and pattern.dtype != np.float64:
                raise LogError(f"a pattern has the dtype {pattern.dtype}", expected="float64")
            profiles.append(CompiledProfile(step_size, ticks[pieces : pieces + rows], part, pattern))
        except GranularError as error:
            raise damage_error(f"profile {len(profiles)} is invalid: {error}", "steps") from error
        pieces, number = pieces + rows, number + rows * columns


def _record_array(record: Record, name: str, dtype: type, dimensions: int = 1) -> np.ndarray:
    array = record.arrays.get(name)
    if array is None or array.dtype != dtype or array.ndim != dimensions:
        raise damage_error(f"a record has no valid array {name!r}", "steps")
    return array


@dataclass(frozen=True, slots=True)
class InputInterval:
    """An interval in which an input had a constant value or followed a profile.

    Attributes:
        begin, end: first and last tick, equal if no tick passed before a step set the input.
        value: the constant value or the profile.
        shift: difference between ticks of the log and ticks of the component.
    """

    begin: int
    end: int
    value: Held
    shift: int = 0

    def sample_ticks(self) -> list[int]:
        """Return ticks at which to sample the input for a plot: both ends and, of a profile, breakpoints and some between."""
        if not isinstance(self.value, CompiledProfile):
            return [self.begin, self.end]
        if self.end <= self.begin:
            return []
        even = np.linspace(self.begin, self.end, _PROFILE_SAMPLES).astype(np.int64)
        grid = np.unique(np.concatenate([even, self.value.ticks, self._curved_ticks(self.value), [self.end]]))
        return grid[(grid >= self.begin) & (grid <= self.end)].tolist()

    def _curved_ticks(self, profile: CompiledProfile) -> np.ndarray:
        """Return ticks inside the curved pieces of a profile, at which a plot samples it so that it misses no short pulse."""
        begins = np.clip(profile.ticks, self.begin, self.end)
        ends = np.append(begins[1:], self.end)
        curved = (ends > begins) & profile.coefficients[:, 2:].any(axis=1)
        each = max(2, min(_PIECE_SAMPLES, _PROFILE_SAMPLES * _PIECE_SAMPLES // max(1, int(curved.sum()))))
        return np.linspace(begins[curved], ends[curved], each + 1).astype(np.int64).ravel()


def input_intervals(
    steps: StepHistory, start: Mapping[str, Held], name: str, end: int, shift: int = 0
) -> Iterator[InputInterval]:
    """Yield the intervals between the changes of input `name` in a segment; `start` has the inputs before the first step."""
    places, values = steps.sets.get(name, (np.zeros(0, np.int64), []))
    begins = [int(steps.marks[0]), *steps.marks[places].tolist()]
    for begin, stop, value in zip(begins, [*begins[1:], end], [start[name], *values], strict=True):
        yield InputInterval(begin, stop, value, shift)


def acting_intervals(log: Any, name: str) -> list[InputInterval]:
    """Return the intervals of non-zero length between changes of an input, each with the value or profile held in it."""
    return [one for one in log.input_intervals(name) if one.end > one.begin]


def sample_intervals(intervals: Sequence[InputInterval], ticks: Iterable[int]) -> Iterator[Any]:
    """Yield the values of an input at the given ascending ticks of the log; at a jump, the value after the jump."""
    place = 0
    for tick in ticks:
        while place + 1 < len(intervals) and intervals[place + 1].begin + intervals[place + 1].shift <= tick:
            place += 1
        yield input_value(intervals[place].value, tick - intervals[place].shift)
