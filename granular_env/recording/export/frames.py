"""The frames of a log that an export contains, read record by record, so that the memory does not depend on the log's size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
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
        self._first = log.start_tick if start is None else math.ceil(start - _ROUNDING)
        self._last = log.end_tick if end is None else math.floor(end + _ROUNDING)
        self._every, self._bar = every, bar

    def __iter__(self) -> Iterator[tuple[float, dict[str, FloatArray]]]:
        """Yield the time [s] and the values of each variable, frame by frame."""
        log, tick, interval = self.log, self._first, -1
        try:
            for frames in zip(*map(self._read_frames, self.names), strict=False):
                tick, before = frames[0][0], interval
                if any(own != tick for own, _ in frames):
                    raise LogError("its variables were not recorded at the same times", source=log.source)
                interval = math.floor((tick - self._first) / self._every + _ROUNDING) if self._every else before + 1
                if interval > before:
                    self.count += 1
                    yield tick * log.step_size, {name: values for name, (_, values) in zip(self.names, frames, strict=True)}
                if self._bar.is_due():
                    self._bar.update((tick - self._first) / max(self._last - self._first, 1))
        except LogError as error:
            if not self.count:
                raise
            self.missing = f"{error}; frames after {tick * log.step_size:g} s are missing"
        if not self.count:
            span = f"{log.start_tick * log.step_size:g} to {log.end_tick * log.step_size:g} s"
            raise ParameterError("no frame was recorded in this time range", expected=f"a part of {span}", at="start")
        if not log.complete and not self.missing and self._last >= log.end_tick:
            reason = log.container.damage or "its end is missing"
            self.missing = f"the log was not closed: {reason}; the last complete step is at {log.end_tick * log.step_size:g} s"

    def _read_frames(self, name: str) -> Iterator[tuple[int, FloatArray]]:
        """Yield tick and value of each frame of a variable in the time range."""
        for row in self.log.frame_rows(name):
            begin, end = self.log.log_tick(row[SEGMENT], row[[FIRST, LAST]])
            if begin <= self._last and end >= self._first:
                ticks, values = self.log.frames(row, name)
                ticks = self.log.log_tick(row[SEGMENT], ticks)
                inside = (ticks >= self._first) & (ticks <= self._last)
                yield from zip(ticks[inside].tolist(), values[inside], strict=True)
