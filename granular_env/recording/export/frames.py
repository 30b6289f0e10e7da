"""The frames of a log that an export contains, read record by record, so that the memory does not depend on the log's size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...components.errors import LogError, ParameterError
from ...components.support.float_arrays import FloatArray
from ...progress import Bar
from ..index import FIRST, LAST, SEGMENT

if TYPE_CHECKING:
    from ..log import Log

# Tolerance on times, in ticks, because a time in seconds is rarely an exact multiple of the step size.
_ROUNDING = 1e-6
# The times of successive frames, shape (frames,) [s], and the values of each variable, shape (frames, ...).
Block = tuple[FloatArray, dict[str, FloatArray]]


class Frames:
    """The selected frames of some variables in blocks; iterate once.

    The first block is read at once, so a log without a readable frame in the time range is refused before anything is written.

    Attributes:
        log: the log.
        names: the variables.
        count: number of frames read so far.
        missing: a sentence on frames that cannot be read; empty if there are none.
    """

    def __init__(
        self, log: Log, names: Sequence[str], start: float | None, end: float | None, every: float | None, bar: Bar
    ) -> None:
        self.log, self.names, self.count, self.missing = log, tuple(names), 0, ""
        first, last, self._every = (
            None if value is None else _to_ticks(name, value, log.step_size)
            for name, value in (("start", start), ("end", end), ("every", every))
        )
        if self._every is not None and not self._every > 0.0:
            raise ParameterError(f"got {every!r}", expected="a number of seconds above 0", at="every")
        self._first = log.start_tick if first is None else math.ceil(first - _ROUNDING)
        self._last = log.end_tick if last is None else math.floor(last + _ROUNDING)
        # The first selected tick, and the number of the interval of length `every` that contains the last one.
        self._origin, self._interval = None, -1.0
        self._blocks = self._selected_blocks(bar)
        self._head = next(self._blocks)

    def __iter__(self) -> Iterator[Block]:
        yield self._head
        yield from self._blocks

    def _selected_blocks(self, bar: Bar) -> Iterator[Block]:
        log, end = self.log, self._first
        try:
            for ticks, values in self._read_blocks():
                inside = self._is_selected(ticks)
                if inside.any():
                    self.count += int(inside.sum())
                    yield ticks[inside] * log.step_size, {name: one[inside] for name, one in values.items()}
                end = int(ticks[-1])
                bar.update((end - self._first) / max(self._last - self._first, 1))
        except LogError as error:
            if not self.count:
                raise
            self.missing = f"{error}; frames after {end * log.step_size:g} s are missing"
        if not self.count:
            span = f"{log.start_tick * log.step_size:g} to {log.end_tick * log.step_size:g} s"
            raise ParameterError("no frame was recorded in this time range", expected=f"a part of {span}", at="start")
        if not log.complete and not self.missing and self._last >= log.end_tick:
            reason = log.container.damage or "its end is missing"
            self.missing = f"the log was not closed: {reason}; the last complete step is at {log.end_tick * log.step_size:g} s"

    def _is_selected(self, ticks: np.ndarray) -> np.ndarray:
        """Return which frames are in the time range and are the first in their interval of length `every`."""
        inside = (ticks >= self._first) & (ticks <= self._last)
        if self._every is not None and inside.any():
            self._origin = ticks[inside][0] if self._origin is None else self._origin
            numbers = np.floor((ticks[inside] - self._origin) / self._every + _ROUNDING)
            inside[inside] = np.diff(numbers, prepend=self._interval) > 0
            self._interval = numbers[-1]
        return inside

    def _read_blocks(self) -> Iterator[Block]:
        """Yield ticks and values of the frames that the next records of all variables have in common."""
        streams = [self._read_records(name) for name in self.names]
        held = [next(stream, None) for stream in streams]
        while any(held):
            records = [one for one in held if one is not None]
            size = min(len(ticks) for ticks, _ in records)
            ticks = records[0][0][:size]
            if len(records) < len(held) or any(not np.array_equal(ticks, own[:size]) for own, _ in records):
                raise LogError("its variables were not recorded at the same times", source=self.log.source)
            yield ticks, {name: values[:size] for name, (_, values) in zip(self.names, records, strict=True)}
            held = [
                (own[size:], values[size:]) if size < len(own) else next(stream, None)
                for (own, values), stream in zip(records, streams, strict=True)
            ]

    def _read_records(self, name: str) -> Iterator[tuple[np.ndarray, FloatArray]]:
        """Yield ticks of the log and values of each record of a variable that overlaps the time range."""
        for row in self.log.frame_rows(name):
            begin, end = self.log.log_tick(row[SEGMENT], row[[FIRST, LAST]])
            if begin <= self._last and end >= self._first:
                ticks, values = self.log.frames(row, name)
                yield self.log.log_tick(row[SEGMENT], ticks), values


def _to_ticks(name: str, seconds: float, step_size: float) -> float:
    try:
        ticks = float(seconds) / step_size
    except (TypeError, ValueError):
        ticks = math.nan
    if not math.isfinite(ticks):
        raise ParameterError(f"got {seconds!r}", expected="a number of seconds", at=name)
    return ticks
