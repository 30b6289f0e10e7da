"""Comparison of two logs of one component, bit for bit: outputs at common times, inputs, events and settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from ..components.errors import ParameterError
from ..components.variables import Variable
from ..output_files import count_text
from .header import header_table
from .log import Log
from .steps import acting_intervals, sample_intervals

Logs = tuple[Log, Log]
FramePairs = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]
# Numbers of one output that are read at a time.
_BLOCK = 2_000_000
# Parts of a header whose differences are listed, and settings that are not; the component is in the parameters.
_SETTINGS = ("parameters", "versions", "machine", "experiment", "step_size")
_OMITTED = ("experiment.component", "experiment.description")


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference between the values of an input or output, or between the events.

    Attributes:
        kind: "input", "output" or "events".
        name: name of the variable; "events" for events.
        unit: unit of the values.
        time: first common time of the difference [s].
        index: index of the first differing element; empty for a number.
        values: the two values; for events, the numbers of events in the time span that both logs cover.
        largest: largest magnitude of the difference over elements and common times; None for inputs and events.
        largest_index: index of the element with the largest difference.
    """

    kind: str
    name: str
    unit: str
    time: float
    index: tuple[int, ...]
    values: tuple[float, float]
    largest: float | None = None
    largest_index: tuple[int, ...] = ()

    def __str__(self) -> str:
        if self.kind == "events":
            return f"events from {self.time:.9g} s on, {self.values[0]} and {self.values[1]} in the common time"
        element = f"[{','.join(map(str, self.index))}]" if self.index else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.kind} {self.name}{element} at {self.time:.9g} s: {self.values[0]!r} and {self.values[1]!r}{unit}"


@dataclass(frozen=True, slots=True)
class LogComparison:
    """The differences between two logs, A and B.

    Attributes:
        relation: sentence on the logs if one is a branch of the other; else "".
        span: start and end of the time that both logs contain [s].
        frames: largest number of common times of an output.
        compared: names of the compared outputs and inputs.
        not_compared: names of the other outputs and inputs.
        differences: the first difference of each variable and of the events, in the order of time.
        settings: settings that differ (they do not count as differences): name and both values, None if missing.
    """

    relation: str
    span: tuple[float, float]
    frames: int
    compared: list[str]
    not_compared: list[str]
    differences: list[Difference]
    settings: list[tuple[str, Any, Any]]

    @property
    def outcome(self) -> str:
        """The result as "identical", "different" or "nothing was compared"."""
        return "different" if self.differences else "identical" if self.frames else "nothing was compared"

    @property
    def message(self) -> str:
        """The result as text: the first difference, or the numbers of identical outputs and times."""
        if self.differences:
            return f"first difference: {self.differences[0]}"
        if not self.frames:
            return "nothing was compared: the logs have no output with a common time"
        variables, times = count_text(len(self.compared), "variable"), count_text(self.frames, "common time")
        return f"identical: {variables} at {times} from {self.span[0]:.9g} s to {self.span[1]:.9g} s, and the events"

    @property
    def omission(self) -> str:
        """Sentence on the variables that were not compared; "" if all were."""
        names = ", ".join(self.not_compared)
        return names and f"Not compared, because they are in one log only, or shapes or step sizes differ: {names}."


def compare_logs(first: Log, second: Log) -> LogComparison:
    """Compare two logs at their common times; `ParameterError` if they have different components."""
    logs = first, second
    components = [log.header.get("component") for log in logs]
    if components[0] != components[1]:
        raise ParameterError(f"got {components[0]!r} and {components[1]!r}", expected="two logs of one component", at="logs")
    span = max(log.start_tick * log.step_size for log in logs), min(log.end_tick * log.step_size for log in logs)
    outputs = [{name: one for name, one in log.variables.items() if one.causality == "output"} for log in logs]
    inputs = [log.input_variables for log in logs]
    frames = {name: _common_frames(logs, name) for name in _common_names(*outputs)}
    acted = _common_names(*inputs) if first.step_size == second.step_size else []
    found = [_event_difference(logs, span), *(_input_difference(logs, inputs[0][name]) for name in acted)]
    found += [_output_difference(logs, outputs[0][name], own) for name, own in frames.items()]
    compared, known = [*frames, *acted], {**outputs[0], **outputs[1], **inputs[0], **inputs[1]}
    headers = [{name: log.header.get(name) for name in _SETTINGS} for log in logs]
    return LogComparison(
        _branch_sentence(first, second, "B is a branch of A") or _branch_sentence(second, first, "A is a branch of B"),
        span,
        max((len(own) for own, _ in frames.values()), default=0),
        compared,
        [name for name in known if name not in compared],
        sorted(filter(None, found), key=lambda one: one.time),
        list(_different_settings(headers[0], headers[1])),
    )


def _common_names(first: Mapping[str, Variable], second: Mapping[str, Variable]) -> list[str]:
    """Return the names of the variables that both logs contain with one shape."""
    return [name for name, one in first.items() if name in second and one.shape == second[name].shape]


def _branch_sentence(parent: Log, log: Log, words: str) -> str:
    is_branch = header_table(log.header.get("parent")).get("log") == parent.identity
    return f"{words} from {log.start_tick * log.step_size:.9g} s on." if is_branch else ""


def _common_frames(logs: Logs, name: str) -> FramePairs:
    """Return the indices of the frames of an output at the times (to a thousandth of a tick) of both logs, for each log."""
    marks = [np.rint(1000.0 * log.times(name) / logs[0].step_size) for log in logs]
    return np.intersect1d(marks[0], marks[1], return_indices=True)[1:]


def _output_difference(logs: Logs, variable: Variable, frames: FramePairs) -> Difference | None:
    name, found, largest, largest_index = variable.name, None, 0.0, ()
    blocks = range(0, len(frames[0]), max(1, _BLOCK // max(1, prod(variable.shape))))
    for block in (slice(start, start + blocks.step) for start in blocks):
        values = [log.frames_at(name, own[block]) for log, own in zip(logs, frames, strict=True)]
        places = np.argwhere(values[0].view(np.int64) != values[1].view(np.int64))
        if len(places):
            with np.errstate(invalid="ignore", over="ignore"):
                change = np.nan_to_num(np.abs(values[0] - values[1]), posinf=np.inf)
            if (most := float(change.max())) > largest:
                largest, largest_index = most, tuple(np.argwhere(change == most)[0, 1:].tolist())
            frame, *index = places[0].tolist()
            pair = float(values[0][frame, *index]), float(values[1][frame, *index])
            found = found or (float(logs[0].times(name)[frames[0][block][frame]]), tuple(index), pair)
    return found and Difference("output", name, variable.unit, *found, largest, largest_index or found[1])


def _input_difference(logs: Logs, variable: Variable) -> Difference | None:
    """Compare an input at the ends of its intervals and at samples of its profiles."""
    intervals = [acting_intervals(log, variable.name) for log in logs]
    if not all(intervals):  # a log without a step
        return None
    first, last = max(log.start_tick for log in logs), min(log.end_tick for log in logs)
    sampled = {first} | {tick + one.shift for own in intervals for one in own for tick in one.sample_ticks()}
    ticks = sorted(tick for tick in sampled if first <= tick < last)
    for tick, *values in zip(ticks, *(sample_intervals(own, ticks) for own in intervals), strict=True):
        if np.any(values[0] != values[1]):
            index = tuple(np.argwhere(values[0] != values[1])[0].tolist()) if variable.shape else ()
            pair = float(np.asarray(values[0])[index]), float(np.asarray(values[1])[index])
            return Difference("input", variable.name, variable.unit, tick * logs[0].step_size, index, pair)
    return None


def _event_difference(logs: Logs, span: tuple[float, float]) -> Difference | None:
    events = [[(one.tick * log.step_size, one.kind, one.index, one.value, one.limit) for one in log.events()] for log in logs]
    rows = [[row for row in own if span[0] < row[0] <= span[1]] for own in events]
    pair = next((pair for pair in zip_longest(*rows) if pair[0] != pair[1]), None)
    time = min(row[0] for row in pair if row) if pair else 0.0
    return Difference("events", "events", "1", time, (), (len(rows[0]), len(rows[1]))) if pair else None


def _different_settings(first: dict[str, Any], second: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the settings that differ; those in tables are named TABLE.SETTING."""
    for name in {**first, **second}:
        match first.get(name), second.get(name):
            case dict() as one, dict() as other:
                yield from _different_settings(one, other, f"{prefix}{name}.")
            case one, other if one != other and not f"{prefix}{name}".startswith(_OMITTED):
                yield f"{prefix}{name}", one, other
