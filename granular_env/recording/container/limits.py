"""Limits on what a log may ask for: a file from a stranger must not fill the memory or run for days.

`allow_large=True` (on the command line ``--allow-large``) lifts every cap but those that no honest file can pass: an array
is never larger than the bytes that hold it, and nothing than the memory that is there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from ...components.errors import Fault, LogError, Option
from ...components.support.memory_limits import refuse_beyond, whole_memory

_ADVICE = ("pass ", Option("allow_large"), " if you trust where it comes from")
# One chunk is decompressed as a whole; ours are near 1 MB or hold one array, which for the largest components is more [bytes].
_CHUNK_BYTES = 256 << 20
# A log that this machine could record, it may read as well: part of its memory that one chunk may take, and what one of
# the things that a component counts takes in it, at least [bytes].
_CHUNK_SHARE, _COMPONENT_SHARE, _UNIT_BYTES = 4, 2, 160
# What reading one variable, or all the steps, may allocate [bytes].
_SERIES_BYTES = 8 << 30
# The largest whole number among a component's parameters (grains, nodes, cells): at least, and at most, by the memory here.
_COUNT, _MOST = 10_000_000, 100_000_000
# Records for each byte of a file, at most: ours hold a digest that no compression shortens, and are listed in the file.
_BYTES_A_RECORD, _RECORDS = 4, 1000
# JSON text of one record: parsed, it takes up to forty times its length [bytes]; more where the file itself is large.
_TEXT_BYTES, _TEXT_SHARE = 16 << 20, 8
# Ticks in one log, and ticks times words of state: about a day's work.
_TICKS = 10_000_000_000
_WORK = 10**14


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits for one log; each check raises `LogError` with both numbers."""

    path: str
    lifted: bool = False

    def _check(self, what: str, value: int, limit: int) -> None:
        if value > limit and not self.lifted:
            raise LogError(Fault((), f"{what} is {value}, the limit is {limit}", hint=_ADVICE, source=f"log {self.path!r}"))

    def chunk(self, size: int) -> None:
        """Bytes that a chunk says it decompresses to."""
        self._check(
            "the decompressed size of a chunk, in bytes,", size, max(_CHUNK_BYTES, (whole_memory() or 0) // _CHUNK_SHARE)
        )
        if size > _CHUNK_BYTES:
            refuse_beyond(size, f"log {self.path!r}: a chunk", LogError)

    def records(self, number: int, size: int) -> None:
        """Refuse too many records in a part of the file of that size [bytes]: each becomes an object, however small."""
        limit = _RECORDS + size // _BYTES_A_RECORD
        if number > limit:
            self._check(f"the number of records in {size} bytes", number, limit)

    def text(self, file_size: int) -> int | None:
        """Return how many bytes of JSON one record of a file of that size may hold; None for any number."""
        return None if self.lifted else max(_TEXT_BYTES, _TEXT_SHARE * file_size)

    def series(self, size: int) -> None:
        """Bytes that the arrays asked for will take."""
        self._check("the size of what was asked for, in bytes,", size, _SERIES_BYTES)
        refuse_beyond(size, f"log {self.path!r}: what was asked for", LogError)

    def work(self, ticks: int, words: int) -> None:
        """Refuse a replay of too many internal steps, for a state of so many 8-byte words."""
        self._check("the number of ticks", ticks, _TICKS)
        self._check("the number of ticks times the words of the state", ticks * max(words, 1), _WORK)

    def parameters(self, given: Mapping[str, Any], model: type[BaseModel]) -> None:
        """Refuse too large whole numbers (grains, nodes, cells) among the parameters of a component to be built."""
        limit = max(_COUNT, min(_MOST, (whole_memory() or 0) // (_COMPONENT_SHARE * _UNIT_BYTES)))
        for name, field in model.model_fields.items():
            value = given.get(name)
            if field.annotation is int and isinstance(value, (int, float)) and not value <= limit:
                self._check(f"parameter {name!r}", int(min(value, 2.0**62)), limit)
