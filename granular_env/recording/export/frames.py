"""The frames of a log that an export contains, read record by record, so that the memory does not depend on the log's size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...components.errors import LogError, ParameterError
from ...components.support.float_arrays import FloatArray
from ...progress import Bar
from ..index import FIRST, LAST, SEGMENT

if TYPE_CHECKING:
    from ..log import Log

# Tolerance on times, in ticks, because a time in seconds is rarely an exact multiple of the step size.
_ROUNDING = 1e-6


class Selection(NamedTuple):
    """The time range of an export; None for the first or last frame, or for every frame.

    Attributes:
        start, end: times of the first and last frame [s].
        every: least time between frames [s].
    """

    start: float | None
    end: float | None
    every: float | None


class Block(NamedTuple):
    """Successive frames.

    Attributes:
        times: shape (frames,) [s].
        values: arrays of shape (frames, ...) by variable.
    """

    times: FloatArray
    values: Mapping[str, FloatArray]


class Frames:
    """The selected frames of some variables in blocks; iterate once.

    The first block is read at once, so a log without a readable frame in the time range is refused before anything is written.

    Attributes:
        log: the log.
        names: the variables.
        count: number of frames read so far.
        missing: a sentence on frames that cannot be read; empty if there are none.
    """

    def __init__(self, log: Log, names: Sequence[str], selection: Selection, bar: Bar) -> None:
        """Read the first block.

        Raises:
            LogError: the log is damaged before its first frame.
            ParameterError: the time range is invalid or contains no frame.
        """
        self.log, self.names, self.count, self.missing = log, tuple(names), 0, ""
        self._bar = bar
        start, end, every = (_ticks(name, value, log.step_size) for name, value in selection._asdict().items())
        if every is not None and not every > 0.0:
            raise ParameterError(f"got {selection.every!r}", expected="a number of seconds above 0", at="every")
        self._first = log.start_tick if start is None else math.ceil(start - _ROUNDING)
        self._last = log.end_tick if end is None else math.floor(end + _ROUNDING)
        self._every = every
        # The first selected tick, and the number of the interval of length `every` that contains the last one.
        self._origin, self._interval = None, -1.0

        self._blocks = self._selected_blocks()
        self._head = next(self._blocks)

    def __iter__(self) -> Iterator[Block]:
        """Yield the frames in blocks."""
        yield self._head
        yield from self._blocks

    def _selected_blocks(self) -> Iterator[Block]:
        log, end = self.log, self._first
        try:
            for ticks, values in self._read_blocks():
                inside = self._is_selected(ticks)
                if inside.any():
                    self.count += int(inside.sum())
                    yield Block(ticks[inside] * log.step_size, {name: one[inside] for name, one in values.items()})
                end = int(ticks[-1])
                self._bar.update((end - self._first) / max(self._last - self._first, 1))
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
            chosen = ticks[inside]
            self._origin = chosen[0] if self._origin is None else self._origin
            numbers = np.floor((chosen - self._origin) / self._every + _ROUNDING)
            inside[inside] = np.diff(numbers, prepend=self._interval) > 0
            self._interval = numbers[-1]
        return inside

    def _read_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, FloatArray]]]:
        """Yield ticks and values of the frames that the next records of all variables have in common."""
        streams = {name: self._read_records(name) for name in self.names}
        held = {name: next(stream, None) for name, stream in streams.items()}
        while any(one is not None for one in held.values()):
            size = min(0 if one is None else len(one[0]) for one in held.values())
            parts = {name: (one[0][:size], one[1][:size]) for name, one in held.items() if one is not None}
            ticks = parts[self.names[0]][0] if self.names[0] in parts else np.zeros(0)
            if not size or any(not np.array_equal(ticks, own) for own, _ in parts.values()):
                raise LogError("its variables were not recorded at the same times", source=self.log.source)
            yield ticks, {name: values for name, (_, values) in parts.items()}
            for name, one in held.items():
                assert one is not None
                held[name] = (one[0][size:], one[1][size:]) if size < len(one[0]) else next(streams[name], None)

    def _read_records(self, name: str) -> Iterator[tuple[np.ndarray, FloatArray]]:
        """Yield ticks of the log and values of each record of a variable that overlaps the time range."""
        for row in self.log.frame_rows(name):
            begin, end = self.log.log_tick(row[SEGMENT], row[[FIRST, LAST]])
            if begin <= self._last and end >= self._first:
                ticks, values = self.log.frames(row, name)
                yield self.log.log_tick(row[SEGMENT], ticks), values


def _ticks(name: str, seconds: float | None, step_size: float) -> float | None:
    try:
        ticks = None if seconds is None else float(seconds) / step_size
    except (TypeError, ValueError):
        ticks = math.nan
    if ticks is not None and not math.isfinite(ticks):
        raise ParameterError(f"got {seconds!r}", expected="a number of seconds", at=name)
    return ticks
