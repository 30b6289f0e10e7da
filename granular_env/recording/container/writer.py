"""Writes the MCAP container: chunks compressed part by part, without ever joining large arrays, and the summary at the end.

The small records are those of the `mcap` package.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, Protocol

import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

Part = bytes | memoryview
_MESSAGE_HEAD = struct.Struct("<BQHIQQ")
_CHUNK_HEAD = struct.Struct("<BQQQQII")
_LENGTH = struct.Struct("<Q")
_COMPRESSION = b"lz4"
# Parts up to this size are joined, chunks from that size on compressed twice, and parts given to the compressor in such slices.
_SMALL, _LARGE, _SLICE = 1 << 16, 1 << 22, 1 << 19


class Sink(Protocol):
    """A file, or what stands for one."""

    def write(self, data: Any) -> int:
        """Write bytes."""
        ...

    def flush(self) -> None:
        """Hand what was written to the operating system."""
        ...


class McapWriter:
    """An MCAP file being written; `flush` ends a chunk, `finish` the file."""

    def __init__(self, file: Sink, profile: str, library: str) -> None:
        """Write the magic bytes and the header."""
        self._file, self._offset = file, 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        self._span: tuple[int, int] | None = None
        self._begin_chunk()
        self._write(MCAP0_MAGIC, _bytes_of(Header(profile, library)))

    def _begin_chunk(self) -> None:
        self._parts: list[Part] = []
        self._size = self._messages = 0
        self._index: dict[int, MessageIndex] = {}
        self._first, self._last = 2**63, 0

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Write a schema and return its number."""
        self._schemas.append(Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data))
        self._append([_bytes_of(self._schemas[-1])])
        return len(self._schemas)

    def add_channel(self, topic: str, encoding: str, schema: int) -> int:
        """Write a channel and return its number."""
        number = len(self._channels) + 1
        self._channels.append(Channel(id=number, topic=topic, message_encoding=encoding, metadata={}, schema_id=schema))
        self._append([_bytes_of(self._channels[-1])])
        return number

    def add_metadata(self, name: str, texts: dict[str, str]) -> None:
        """One Metadata record, between the chunks."""
        record = _bytes_of(Metadata(name=name, metadata=texts))
        self._metadata.append(MetadataIndex(offset=self._offset, length=len(record), name=name))
        self._write(record)

    def add_message(
        self, channel: int, sequence: int, nanoseconds: int, parts: Sequence[Part], publish_time: int | None = None
    ) -> None:
        """One message, given in parts that must not change until `flush`; `publish_time` is its time but for stock viewers."""
        published = nanoseconds if publish_time is None else publish_time
        index = self._index.setdefault(channel, MessageIndex(channel, []))
        index.records.append((nanoseconds, self._size))
        size = sum(map(len, parts))
        length = _MESSAGE_HEAD.size - 9 + size
        self._parts += (_MESSAGE_HEAD.pack(Opcode.MESSAGE, length, channel, sequence, nanoseconds, published), *parts)
        self._size += _MESSAGE_HEAD.size + size
        self._first, self._last = min(self._first, nanoseconds), max(self._last, nanoseconds)
        self._messages += 1
        self._counts[channel] = self._counts.get(channel, 0) + 1

    def flush(self) -> None:
        """End the chunk, if it has messages, and hand everything to the operating system."""
        if self._messages:
            self._write_chunk()
            low, high = self._span or (self._first, self._last)
            self._span = (min(low, self._first), max(high, self._last))
            self._begin_chunk()
        self._file.flush()

    def finish(self) -> None:
        """Write the end of the file."""
        self.flush()
        self._write(_bytes_of(DataEnd(0)))
        start = self._offset
        groups: list[tuple[int, Sequence[McapRecord]]] = [
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, self._metadata),
        ]
        summary, offsets = b"", []
        for opcode, records in groups:
            if not records:
                continue
            part = b"".join(map(_bytes_of, records))
            offsets.append(SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(part)))
            summary += part
        offsets_start = start + len(summary)
        summary += b"".join(map(_bytes_of, offsets))
        unchecked = _bytes_of(Footer(start, offsets_start, 0))[:-4]
        crc = zlib.crc32(unchecked, zlib.crc32(summary))
        self._write(summary, unchecked, struct.pack("<I", crc), MCAP0_MAGIC)
        self._file.flush()

    def _statistics(self) -> Statistics:
        first, last = self._span or (0, 0)
        return Statistics(
            message_count=sum(self._counts.values()), schema_count=len(self._schemas), channel_count=len(self._channels),
            attachment_count=0, metadata_count=len(self._metadata), chunk_count=len(self._chunks), message_start_time=first,
            message_end_time=last, channel_message_counts=self._counts,
        )  # fmt: skip

    def _write_chunk(self) -> None:
        parts, crc = list(_join_small_parts(self._parts)), 0
        for part in parts:
            crc = zlib.crc32(part, crc)
        pieces: Iterable[bytes]
        if self._size < _LARGE:
            pieces = [b"".join(_compress(parts))]
            size = len(pieces[0])
        else:  # the size comes first in the file; a large state is compressed twice, as the pieces would take its memory again
            size = sum(map(len, _compress(parts)))
            pieces = _compress(parts)
        length = _CHUNK_HEAD.size - 9 + len(_COMPRESSION) + _LENGTH.size + size
        head = _CHUNK_HEAD.pack(Opcode.CHUNK, length, self._first, self._last, self._size, crc, len(_COMPRESSION))
        begin = self._offset
        self._write(head, _COMPRESSION, _LENGTH.pack(size))
        for piece in pieces:
            self._write(piece)
        end = self._offset
        places, indices, place = {}, [], end
        for channel, index in self._index.items():
            places[channel] = place
            indices.append(_bytes_of_index(index))
            place += len(indices[-1])
        self._write(b"".join(indices))
        self._chunks.append(
            ChunkIndex(
                chunk_length=end - begin,
                chunk_start_offset=begin,
                compression=_COMPRESSION.decode(),
                compressed_size=size,
                message_end_time=self._last,
                message_index_length=self._offset - end,
                message_index_offsets=places,
                message_start_time=self._first,
                uncompressed_size=self._size,
            )  # fmt: skip
        )

    def _append(self, parts: Sequence[Part]) -> None:
        self._parts += parts
        self._size += sum(len(part) for part in parts)

    def _write(self, *parts: Part) -> None:
        write: Callable[[Part], object] = self._file.write
        for part in parts:
            write(part)
            self._offset += len(part)


def _join_small_parts(parts: Sequence[Part]) -> Iterator[Part]:
    """Small parts together, large ones as they are: each call to compress may cost a wait for the interpreter's lock."""
    small: list[Part] = []
    for part in parts:
        if len(part) < _SMALL:
            small.append(part)
        else:
            yield b"".join(small)
            yield memoryview(part)
            small = []
    yield b"".join(small)


def _compress(parts: Iterable[Part]) -> Iterator[bytes]:
    """Yield a frame of lz4, piece by piece."""
    compressor = lz4.frame.LZ4FrameCompressor()
    yield compressor.begin()
    for part in parts:
        # The compressor's own buffer is as large as what it is given.
        for begin in range(0, len(part), _SLICE):
            yield compressor.compress(part[begin : begin + _SLICE])
    yield compressor.flush()


def _bytes_of_index(index: MessageIndex) -> bytes:
    """Return the bytes of an index, which may have thousands of numbers: the package writes each by itself."""
    size = 16 * len(index.records)
    numbers = chain.from_iterable(index.records)
    return struct.pack(f"<BQHI{2 * len(index.records)}Q", Opcode.MESSAGE_INDEX, 6 + size, index.channel_id, size, *numbers)


def _bytes_of(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
