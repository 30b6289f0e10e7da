"""The MCAP container of a log, read by the `mcap` package with checks against untrusted files.

The package trusts the sizes declared in a file, so each size is checked before memory is allocated: no read exceeds the end of
the file, a chunk is decompressed only up to its declared size, and this size and the number of records are limited.
`allow_large=True` (``--allow-large``) lifts the limits.

A *complete* file ends in a summary, which lists its chunks. A file whose end is missing (the process was killed, the disk was
full) is scanned from the front to the first truncated or damaged record.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, NamedTuple

import lz4.frame
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Header, McapRecord, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from ..components.errors import Fault, LogError
from ..components.support.memory_limits import refuse_excess_memory, total_memory
from .records import PROFILE

NOT_A_LOG = "an MCAP file that is not a log of granular-env, or whose first record is lost"
_RECORD = struct.Struct("<BQ")
_FOOTER_BYTES = _RECORD.size + 20 + len(MCAP0_MAGIC)
_RECOVER = "`granular-env recover` saves the intact part"
# A chunk may decompress to this many bytes or to 1/_CHUNK_SHARE of the memory. Our chunks are near 1 MB or hold one array.
_CHUNK_BYTES, _CHUNK_SHARE = 256 << 20, 4
# Limits on the records of a chunk: one per this many bytes of the file plus this number. Each record becomes an object.
_BYTES_A_RECORD, _RECORDS = 4, 1000
# Limits on a record's JSON text: this many bytes, or this many per byte of the file. Parsing takes up to 40 times its length.
_TEXT_BYTES, _TEXT_SHARE = 16 << 20, 8
# Size of the cache of decompressed chunks, and memory that a message takes in addition to its data [bytes].
_CACHE_BYTES, _OBJECT_BYTES = 64 << 20, 200
_FAULTS = (McapError, struct.error, ValueError, RuntimeError, OverflowError)


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits for a log; each check raises `LogError` with both numbers.

    Attributes:
        path: path of the log.
        lifted: whether the limits do not apply, because the user trusts the origin of the log.
    """

    path: str
    lifted: bool = False

    @property
    def source(self) -> str:
        """Name of the log in messages."""
        return f"log {self.path!r}"

    def check(self, what: str, value: int, limit: int) -> None:
        """Raise an error if `value`, the size or number called `what`, is above `limit`, unless the limits are lifted."""
        if value > limit and not self.lifted:
            hint = "pass allow_large=True (--allow-large) if you trust the origin of the log"
            raise LogError(f"{what} is {value}, the limit is {limit}", hint=hint, source=self.source)

    def check_chunk(self, size: int) -> None:
        """Refuse a chunk that declares too large a decompressed size [bytes]."""
        limit = max(_CHUNK_BYTES, (total_memory() or 0) // _CHUNK_SHARE)
        self.check("the decompressed size of a chunk, in bytes,", size, limit)
        if size > _CHUNK_BYTES:
            refuse_excess_memory(size, f"{self.source}: a chunk", LogError)

    def check_records(self, number: int, size: int) -> None:
        """Raise an error if a part of the file of this size [bytes] contains too many records."""
        if number > _RECORDS + size // _BYTES_A_RECORD:
            self.check(f"the number of records in {size} bytes", number, _RECORDS + size // _BYTES_A_RECORD)

    def text_limit(self, file_size: int) -> int | None:
        """Return the limit on the JSON text of one record in a file of this size [bytes]; None for no limit."""
        return None if self.lifted else max(_TEXT_BYTES, _TEXT_SHARE * file_size)


class _BoundedFile:
    """A file for the `mcap` package that never reads (and allocates) beyond its end."""

    def __init__(self, file: IO[bytes], size: int) -> None:
        self._file, self.size = file, size
        self.seek, self.tell = file.seek, file.tell

    def read(self, length: int) -> bytes:
        if not 0 <= length <= self.size - self._file.tell():
            raise EndOfFile
        return self._file.read(length)


class Entry(NamedTuple):
    """A message and the topic of its channel."""

    topic: str
    message: Message


class Container:
    """An MCAP file opened for reading.

    Attributes:
        path: the file.
        size: size of the file [bytes].
        text_limit: limit on the JSON in a message [bytes]; None for no limit.
        complete: whether the file ends in a summary.
        places: offset and length of each readable chunk [bytes].
        damage: for an incomplete file, the reason why the scan stopped.
        bytes_lost: for an incomplete file, number of bytes after the point at which the scan stopped.
    """

    def __init__(self, path: Path, limits: Limits, scan: bool = False) -> None:
        """Find the chunks; with `scan`, scan the file even if it has a summary.

        Raises:
            LogError: not a log, an unreadable file, or a complete file with a damaged summary.
        """
        self.path, self.limits = path, limits
        self.complete, self.damage, self.bytes_lost = False, "", 0
        self.places: list[tuple[int, int]] = []
        self.topics: dict[int, str] = {}
        self._cache: dict[int, list[Entry]] = {}
        self._cached_bytes = 0
        try:
            if path.exists() and not path.is_file():
                raise ValueError("it is a folder, a device or a pipe; give the path of a file")
            self._file = path.open("rb")
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise LogError(f"cannot be read: {reason}", source=f"log {str(path)!r}") from error
        try:
            self.size = os.fstat(self._file.fileno()).st_size
            self.text_limit = limits.text_limit(self.size)
            self._bounded = _BoundedFile(self._file, self.size)
            self._find_chunks(scan)
        except BaseException:
            self._file.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def messages(self, chunk: int) -> list[Entry]:
        """Return the messages of a chunk; `LogError` if it is damaged or too large."""
        if chunk not in self._cache:
            if self._file.closed:
                raise LogError("the log is closed", hint="open it again: open_log(path)", source=self.limits.source)
            offset, length = self.places[chunk]
            try:
                found = self._read_chunk(offset, length)
            except _FAULTS as error:
                raise self._damage_error(f"the chunk at byte {offset}") from error
            if self._cached_bytes > _CACHE_BYTES:
                self._cache.clear()
                self._cached_bytes = 0
            self._cache[chunk] = found
            self._cached_bytes += sum(len(entry.message.data) + _OBJECT_BYTES for entry in found)
        return self._cache[chunk]

    def all_messages(self) -> Iterator[tuple[int, Entry]]:
        """Yield the messages of all chunks in order, each with the number of its chunk."""
        for chunk in range(len(self.places)):
            for entry in self.messages(chunk):
                yield chunk, entry

    def _find_chunks(self, scan: bool) -> None:
        if self.size == 0:
            hint = "nothing was written, so nothing can be recovered"
            raise LogError("the file is empty", hint=hint, source=self.limits.source)
        magic = len(MCAP0_MAGIC)
        if self._read_bytes(0, magic) != MCAP0_MAGIC:
            raise LogError("not an MCAP file", expected="a log of granular-env", source=repr(str(self.path)))
        try:
            header = next(self._mcap_records(magic))
        except _FAULTS:
            header = None
        if not isinstance(header, Header) or header.profile != PROFILE:
            raise LogError(NOT_A_LOG, source=repr(str(self.path)))
        if scan or self._read_bytes(self.size - magic, magic) != MCAP0_MAGIC:
            self._scan_chunks(magic)
            return
        try:
            footer = next(self._mcap_records(self.size - _FOOTER_BYTES))
            records = self._mcap_records(footer.summary_start) if isinstance(footer, Footer) else iter(())
            for number, record in enumerate(records):
                self.limits.check_records(number, self.size)
                if isinstance(record, Channel):
                    self.topics[record.id] = record.topic
                elif isinstance(record, ChunkIndex):
                    self.places.append((record.chunk_start_offset, record.chunk_length))
                self.complete = isinstance(record, Footer)
        except _FAULTS as error:
            raise self._damage_error("the summary") from error
        if not self.complete:
            raise self._damage_error("the footer")

    def _read_bytes(self, offset: int, length: int) -> bytes:
        self._file.seek(offset)
        return self._file.read(length)

    def _mcap_records(self, offset: int) -> Iterator[McapRecord]:
        """Yield the records from a position in the file on, without unpacking chunks."""
        self._file.seek(min(max(offset, 0), self.size))
        return StreamReader(self._bounded, skip_magic=True, emit_chunks=True).records  # type: ignore[arg-type]

    def _scan_chunks(self, offset: int) -> None:
        """Find the chunks from the front up to the first incomplete chunk."""
        while offset < self.size:
            try:
                opcode, length = _RECORD.unpack(self._read_bytes(offset, _RECORD.size))
                end = offset + _RECORD.size + length
                if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                    return
                if end > self.size or not 1 <= opcode < Opcode.DATA_END:
                    raise EndOfFile
                if opcode == Opcode.CHUNK:
                    self._read_chunk(offset, end - offset)
                    self.places.append((offset, end - offset))
            except _FAULTS:
                self.damage = f"the record at byte {offset} is truncated or damaged"
                self.bytes_lost = self.size - offset
                return
            offset = end

    def _read_chunk(self, offset: int, length: int) -> list[Entry]:
        """Return the messages of a chunk; raise one of `_FAULTS` if it is damaged, `LogError` if it is too large."""
        chunk = next(self._mcap_records(offset))
        if not isinstance(chunk, Chunk) or self._file.tell() != offset + length:
            raise ValueError("no chunk")
        found = []
        for record in breakup_chunk(self._decompress_chunk(chunk)):
            if isinstance(record, Channel):
                self.topics[record.id] = record.topic
            elif isinstance(record, Message):
                if record.channel_id not in self.topics:
                    raise ValueError("a message of an unknown channel")
                found.append(Entry(self.topics[record.channel_id], record))
        return found

    def _decompress_chunk(self, chunk: Chunk) -> Chunk:
        """Return a chunk with decompressed content, after checking its size and number of records."""
        size, content = chunk.uncompressed_size, chunk.data
        self.limits.check_chunk(size)
        if chunk.compression == "lz4":
            # Decompress at most one byte more than declared, which suffices to detect content larger than declared.
            content = lz4.frame.LZ4FrameDecompressor().decompress(content, max_length=size + 1)
        elif chunk.compression:
            raise ValueError("a compression other than lz4")
        if len(content) != size or zlib.crc32(content) != chunk.uncompressed_crc:
            raise ValueError("content that does not match its checksum")
        number = offset = 0
        while offset < size:
            _, length = _RECORD.unpack_from(content, offset)
            offset, number = offset + _RECORD.size + length, number + 1
            self.limits.check_records(number, len(chunk.data))
        if offset != size:
            raise ValueError("a record that does not end with its chunk")
        return replace(chunk, compression="", data=content)

    def _damage_error(self, what: str) -> LogError:
        return LogError(Fault(received=f"{self.limits.source} is damaged: {what} is not as it was written", hint=_RECOVER))
