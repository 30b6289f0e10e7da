"""Comparison of two logs of one component: recorded outputs at common times, inputs, events and settings, bit for bit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..components.errors import ParameterError
from ..components.inputs import input_value
from ..components.support.float_arrays import FloatArray
from ..components.variables import Variable
from ..output_files import count_text
from .header import header_table
from .index import COUNT
from .log import Log

# Numbers of one output that are read at a time.
_BLOCK = 2_000_000
# Times count as common if they differ by less than this fraction of a tick.
_TICK_PART = 1e-3


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference between the values of an input or a recorded output.

    Attributes:
        variable: name of the variable, or "events".
        kind: "input", "output" or "events".
        unit: unit of the values.
        time: first common time at which the values differ [s].
        index: index of the first differing element; empty for a number.
        values: the two values; for events, their numbers in the common time of the logs.
        largest: largest magnitude of the difference of all elements at all common times; None for inputs and events.
    """

    variable: str
    kind: str
    unit: str
    time: float
    index: tuple[int, ...]
    values: tuple[float, float]
    largest: float | None = None

    def __str__(self) -> str:
        if self.kind == "events":
            return f"events from {self.time:.9g} s on: {self.values[0]:g} and {self.values[1]:g} in the common time"
        element = f"[{','.join(map(str, self.index))}]" if self.index else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.kind} {self.variable}{element} at {self.time:.9g} s: {self.values[0]!r} and {self.values[1]!r}{unit}"


@dataclass(frozen=True, slots=True)
class Setting:
    """A setting that differs: group ("parameters", "experiment", "versions", "machine", "log"), name and both values."""

    group: str
    name: str
    values: tuple[Any, Any]


@dataclass(frozen=True, slots=True)
class LogComparison:
    """The differences between two logs.

    Attributes:
        span: start and end of the time that both logs contain [s].
        times: largest number of common times of an output.
        compared: names of the compared outputs.
        not_compared: names of outputs that only one log contains, or that have different shapes.
        differences: the first difference of each input and output, and of the events, in the order of time.
        settings: settings that differ.
        relation: sentence on the logs, A and B, if one is a branch of the other; else "".
    """

    span: tuple[float, float]
    times: int
    compared: tuple[str, ...]
    not_compared: tuple[str, ...]
    differences: tuple[Difference, ...]
    settings: tuple[Setting, ...]
    relation: str

    @property
    def outcome(self) -> str:
        """The result as "identical", "different" or "nothing was compared"; settings do not count."""
        return "different" if self.differences else "identical" if self.times else "nothing was compared"

    @property
    def message(self) -> str:
        """The result in a sentence: the first difference, or what is equal."""
        if self.differences:
            return f"first difference: {self.differences[0]}"
        if not self.times:
            return "nothing was compared: the logs have no common output with a common time"
        outputs, times = count_text(len(self.compared), "output"), count_text(self.times, "common time")
        return f"identical: {outputs} at {times} from {self.span[0]:.9g} s to {self.span[1]:.9g} s, inputs and events"


def compare_logs(first: Log, second: Log) -> LogComparison:
    """Compare the recorded outputs of two logs at their common times, and the inputs and events in their common time.

    Raises:
        ParameterError: the logs have different components.
    """
    logs = (first, second)
    components = [log.header.get("component") for log in logs]
    if components[0] != components[1]:
        raise ParameterError(f"got {components[0]!r} and {components[1]!r}", expected="two logs of one component", at="logs")
    start = max(log.start_tick * log.step_size for log in logs)
    end = min(log.end_tick * log.step_size for log in logs)
    outputs = [{name: one for name, one in log.variables.items() if one.causality == "output"} for log in logs]
    same = [name for name, one in outputs[0].items() if name in outputs[1] and one.shape == outputs[1][name].shape]
    found: list[Difference | None] = [_first_event_difference(logs, end)]
    if first.step_size == second.step_size:
        found += [_first_input_difference(logs, one) for one in first.input_variables.values()]
    found += [_first_output_difference(logs, first.variables[name]) for name in same]
    return LogComparison(
        (start, end),
        max((len(common_frames(logs, name)[0]) for name in same), default=0),
        tuple(same),
        tuple(name for name in dict.fromkeys([*outputs[0], *outputs[1]]) if name not in same),
        tuple(sorted(filter(None, found), key=lambda one: one.time)),
        tuple(_different_settings(logs)),
        _relation(first, second, "B is a branch of A") or _relation(second, first, "A is a branch of B"),
    )


def _relation(parent: Log, log: Log, words: str) -> str:
    is_branch = header_table(log.header.get("parent")).get("log") == parent.identity
    return f"{words}, from {log.start_tick * log.step_size:.9g} s on." if is_branch else ""


def common_frames(logs: tuple[Log, Log], name: str) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the indices of the frames of an output at the times that both logs contain, for each log."""
    resolution = _TICK_PART * min(log.step_size for log in logs)
    marks = [np.rint(log.times(name) / resolution) for log in logs]
    _, first, second = np.intersect1d(marks[0], marks[1], return_indices=True)
    return first, second


def read_frames(log: Log, name: str, frames: npt.NDArray[np.int64]) -> FloatArray:
    """Return the values of an output in frames with ascending indices, shape (frames, *shape)."""
    rows = log.frame_rows(name)
    ends = np.cumsum(rows[:, COUNT])
    first, last = np.searchsorted(ends, frames[[0, -1]], side="right")
    values = np.concatenate([log.frames(row, name)[1] for row in rows[first : last + 1]])
    return np.asarray(values[frames - (ends[first] - rows[first, COUNT])], dtype=np.float64)


def _first_output_difference(logs: tuple[Log, Log], variable: Variable) -> Difference | None:
    name, found, largest = variable.name, None, 0.0
    frames = np.stack(common_frames(logs, name), axis=1)
    size = max(1, int(np.prod(variable.shape)))
    for block in np.array_split(frames, -(-len(frames) * size // _BLOCK) or 1) if len(frames) else ():
        values = [read_frames(log, name, own) for log, own in zip(logs, block.T, strict=True)]
        differs = values[0].view(np.int64) != values[1].view(np.int64)
        if not differs.any():
            continue
        with np.errstate(invalid="ignore", over="ignore"):
            largest = max(largest, float(np.nanmax(np.abs(values[0] - values[1]), initial=0.0)))
        if found is None:
            place = np.unravel_index(int(np.argmax(differs)), differs.shape)
            time = float(logs[0].times(name)[block[place[0], 0]])
            found = time, tuple(int(one) for one in place[1:]), (float(values[0][place]), float(values[1][place]))
    return None if found is None else Difference(name, "output", variable.unit, *found, largest)


def _first_input_difference(logs: tuple[Log, Log], variable: Variable) -> Difference | None:
    """Compare an input at the ends of its intervals and at the samples of its profiles."""
    intervals = [[one for one in log.input_intervals(variable.name) if one.end > one.begin] for log in logs]
    if not all(intervals):
        return None
    first, last = max(log.start_tick for log in logs), min(log.end_tick for log in logs)
    ticks = {first} | {tick + one.shift for own in intervals for one in own for tick in one.sample_ticks()}
    places = [0, 0]
    for tick in sorted(tick for tick in ticks if first <= tick < last):
        values = []
        for side, own in enumerate(intervals):
            while places[side] + 1 < len(own) and own[places[side] + 1].begin + own[places[side] + 1].shift <= tick:
                places[side] += 1
            held = own[places[side]]
            values.append(np.ravel(np.asarray(input_value(held.value, tick - held.shift), dtype=np.float64)))
        differs = values[0].view(np.int64) != values[1].view(np.int64)
        if differs.any():
            place = int(np.argmax(differs))
            index = tuple(int(one) for one in np.unravel_index(place, variable.shape))
            pair = float(values[0][place]), float(values[1][place])
            return Difference(variable.name, "input", variable.unit, tick * logs[0].step_size, index, pair)
    return None


def _first_event_difference(logs: tuple[Log, Log], end: float) -> Difference | None:
    start = max(log.start_tick * log.step_size for log in logs)
    found = [[(one.tick * log.step_size, one.kind, one.index, one.value, one.limit) for one in log.events()] for log in logs]
    rows = [[row for row in own if start < row[0] <= end] for own in found]
    same = next((place for place, pair in enumerate(zip(*rows, strict=False)) if pair[0] != pair[1]), min(map(len, rows)))
    later = [own[same][0] for own in rows if len(own) > same]
    return Difference("events", "events", "1", min(later), (), (len(rows[0]), len(rows[1]))) if later else None


def _different_settings(logs: tuple[Log, Log]) -> Iterator[Setting]:
    """Yield the settings with different values; `None` for a log without the setting."""
    for group in ("experiment", "parameters", "versions", "machine", "log"):
        flat = [dict(_flat_settings("", _setting_table(log, group))) for log in logs]
        for name in dict.fromkeys([*flat[0], *flat[1]]):
            values = flat[0].get(name), flat[1].get(name)
            if values[0] != values[1]:
                yield Setting(group, name, values)


def _setting_table(log: Log, group: str) -> dict[str, Any]:
    """Return a group of settings; the component's part of an experiment is in the parameters."""
    if group == "log":
        start, end = (float(f"{tick * log.step_size:.12g}") for tick in (log.start_tick, log.end_tick))
        return {"start": start, "end": end, "step_size": log.step_size, "complete": log.complete}
    table = header_table(log.header.get(group))
    return {name: value for name, value in table.items() if group != "experiment" or name not in ("component", "description")}


def _flat_settings(prefix: str, table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat_settings(f"{prefix}{name}.", value)
        else:
            yield f"{prefix}{name}", value
