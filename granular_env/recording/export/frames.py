"""The frames of a log that an export contains, read record by record, so that the memory does not depend on the log's size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from ...components.errors import LogError, ParameterError
from ...components.support.float_arrays import FloatArray
from ...components.support.validation import finite_number
from ...progress import Bar
from ..index import FIRST, LAST, SEGMENT

if TYPE_CHECKING:
    from ..log import Log

# Tolerance on times, in ticks, because a time in seconds is rarely an exact multiple of the step size.
_ROUNDING = 1e-6


class Frames:
    """The frames of some variables from `start` to `end`, at most one in each interval of length `every`; iterate once.

    Attributes:
        log: the log.
        names: the variables.
        count: number of frames read so far.
        first, last: the time range [tick].
        missing: a sentence on frames that cannot be read; empty if there are none.
    """

    def __init__(self, log: Log, names: Sequence[str], times: Sequence[float | None], bar: Bar) -> None:
        start, end, every = (
            None if value is None else finite_number(name, value, "seconds") / log.step_size
            for name, value in zip(("start", "end", "every"), times, strict=True)
        )
        if every is not None and every <= 0.0:
            raise ParameterError(f"got {times[-1]!r}", expected="a number of seconds above 0", at="every")
        self.log, self.names, self.count, self.missing = log, tuple(names), 0, ""
        self.first = log.start_tick if start is None else math.ceil(start - _ROUNDING)
        self.last = log.end_tick if end is None else math.floor(end + _ROUNDING)
        self._every, self._bar, self._damage, self._lost = every, bar, None, list[int]()

    def __iter__(self) -> Iterator[tuple[float, dict[str, FloatArray]]]:
        """Yield the time [s] and the values of each variable, frame by frame."""
        log, interval, step_size = self.log, -1, self.log.step_size
        for tick, values in self._common_frames():
            before = interval
            interval = math.floor((tick - self.first) / self._every + _ROUNDING) if self._every else before + 1
            if interval > before:
                self.count += 1
                yield tick * step_size, dict(zip(self.names, values, strict=True))
            if self._bar.is_due():
                self._bar.update((tick - self.first) / max(self.last - self.first, 1))
        if not self.count:
            span = f"{log.start_tick * step_size:g} to {log.end_tick * step_size:g} s"
            error = ParameterError("no frame was recorded in this time range", expected=f"a part of {span}", at="start")
            raise self._damage or error
        if self._damage:
            begin, end = min(self._lost) * step_size, max(self._lost) * step_size
            self.missing = f"{self._damage}; frames from {begin:g} s to {end:g} s are missing"
        elif not log.complete and self.last >= log.end_tick:
            reason = log.container.damage or "its end is missing"
            self.missing = f"the log was not closed: {reason}; the last complete step is at {log.end_tick * step_size:g} s"

    def _common_frames(self) -> Iterator[tuple[int, list[FloatArray]]]:
        """Yield tick and values of the frames that all variables have."""
        streams = [self._read_frames(name) for name in self.names]
        with suppress(StopIteration):
            heads = [next(stream) for stream in streams]
            while True:
                latest = max(head[:2] for head in heads)
                behind = [head[:2] < latest for head in heads]
                if not any(behind):
                    yield latest[1], [head[2] for head in heads]
                    behind = [True for _ in heads]
                heads = [next(stream) if late else head for stream, late, head in zip(streams, behind, heads, strict=True)]

    def _read_frames(self, name: str) -> Iterator[tuple[int, int, FloatArray]]:
        """Yield segment, tick and value of each intact frame of a variable in the time range."""
        for row in self.log.frame_rows(name):
            begin, end = (int(one) for one in self.log.log_tick(row[SEGMENT], row[[FIRST, LAST]]))
            if begin > self.last or end < self.first:
                continue
            try:
                ticks, values = self.log.frames(row, name)
            except LogError as error:
                self._damage = self._damage or error
                self._lost += [max(begin, self.first), min(end, self.last)]
                continue
            for tick, value in zip(self.log.log_tick(row[SEGMENT], ticks).tolist(), values, strict=True):
                if self.first <= tick <= self.last:
                    yield int(row[SEGMENT]), tick, value
