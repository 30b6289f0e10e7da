"""Limits on what a log may ask for: a file from a stranger must not fill the memory or run for days.

Here are those of the container. Others stand where a component is made from a log, where series are read, and where a log runs
again. `allow_large=True` (on the command line ``--allow-large``) lifts all but those that no honest file can pass: an array is
never larger than the bytes that hold it, and nothing than the memory that is there.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...components.errors import Fault, LogError, Option
from ...components.support.memory_limits import refuse_beyond, whole_memory

_ADVICE = ("pass ", Option("allow_large"), " if you trust where it comes from")
# One chunk is decompressed as a whole; ours are near 1 MB or hold one array, which for the largest components is more [bytes].
_CHUNK_BYTES = 256 << 20
# A log that this machine could record, it may read as well: part of its memory that one chunk may take.
_CHUNK_SHARE = 4
# Records for each byte of a file, at most: ours hold a digest that no compression shortens, and are listed in the file.
_BYTES_A_RECORD, _RECORDS = 4, 1000
# JSON text of one record: parsed, it takes up to forty times its length [bytes]; more where the file itself is large.
_TEXT_BYTES, _TEXT_SHARE = 16 << 20, 8


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits for one log; each check raises `LogError` with both numbers.

    Attributes:
        path: of the log.
        lifted: whether its owner trusts where it comes from.
    """

    path: str
    lifted: bool = False

    def check(self, what: str, value: int, limit: int) -> None:
        """Refuse a number beyond its limit, unless the limits are lifted."""
        if value > limit and not self.lifted:
            raise LogError(Fault((), f"{what} is {value}, the limit is {limit}", hint=_ADVICE, source=f"log {self.path!r}"))

    def chunk(self, size: int) -> None:
        """Bytes that a chunk says it decompresses to."""
        self.check(
            "the decompressed size of a chunk, in bytes,", size, max(_CHUNK_BYTES, (whole_memory() or 0) // _CHUNK_SHARE)
        )
        if size > _CHUNK_BYTES:
            refuse_beyond(size, f"log {self.path!r}: a chunk", LogError)

    def records(self, number: int, size: int) -> None:
        """Refuse too many records in a part of the file of that size [bytes]: each becomes an object, however small."""
        limit = _RECORDS + size // _BYTES_A_RECORD
        if number > limit:
            self.check(f"the number of records in {size} bytes", number, limit)

    def text(self, file_size: int) -> int | None:
        """Return how many bytes of JSON one record of a file of that size may hold; None for any number."""
        return None if self.lifted else max(_TEXT_BYTES, _TEXT_SHARE * file_size)
