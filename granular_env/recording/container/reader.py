"""The MCAP container, read with nothing taken on trust: every size is checked before it is believed, every chunk's CRC.

A *complete* file ends in a summary; its chunks are found there and read when asked for. A file whose end is missing (the
process was killed, the disk was full) is scanned from the front, up to the first record that is cut off or damaged.
"""

from __future__ import annotations

import os
import stat
import struct
import zlib
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import IO, Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Footer, Header, McapRecord, Metadata, MetadataIndex
from mcap.writer import MCAP0_MAGIC

from ...components.errors import Fault, LogError, Phrase
from . import PROFILE
from .limits import Limits

_RECORD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_CHUNK_INDEX = struct.Struct("<QQQQ")
_MESSAGE = struct.Struct("<HIQQ")
# As plain numbers, which compare faster: each message of a log is looked at.
_CHANNEL_OP, _MESSAGE_OP = int(Opcode.CHANNEL), int(Opcode.MESSAGE)
_FOOTER_BODY = 20
_FOOTER_BYTES = _RECORD.size + _FOOTER_BODY
# The header's first text, the profile, lies within these [bytes].
_HEADER_BYTES = 256
NOT_A_LOG = "an MCAP file but no log of granular-env, or its first record is lost"
# Decompressed chunks that are kept at hand, and what a message's object takes beside its data [bytes].
_CACHE_BYTES, _OBJECT_BYTES = 64 << 20, 200
_RECOVER = "`granular-env recover` saves what is intact"


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message: its topic, number, time [ns], time of publishing [ns] and bytes."""

    topic: str
    sequence: int
    nanoseconds: int
    published: int
    data: memoryview


class McapReader:
    """An MCAP file opened for reading.

    Attributes:
        path: the file.
        complete: whether it ends in a summary.
        places: offset and length of each chunk that can be read [bytes].
        damage: for an incomplete file: what stopped the scan.
        advice: what to do about that.
        bytes_lost: for an incomplete file: how much follows after that.
    """

    def __init__(self, path: Path, limits: Limits, scan: bool = False) -> None:
        """Find the chunks; `LogError` where that is no MCAP file, or a complete one whose summary is damaged."""
        self.path, self._limits = path, limits
        self.damage, self.bytes_lost = "", 0
        self.advice: Phrase = ""
        self._scanned = len(MCAP0_MAGIC)
        self._cache: OrderedDict[int, list[RawMessage]] = OrderedDict()
        self._cached_bytes = 0
        self._channels: dict[int, str] = {}
        self._metadata: list[tuple[int, int]] = []
        try:
            self._file = _open_regular(path)
        except (OSError, ValueError) as error:
            raise self._unreadable(error) from error
        try:
            self._size = os.fstat(self._file.fileno()).st_size
            if self._size == 0:
                raise LogError(
                    "the file is empty", hint="nothing was written to it, and there is nothing to recover", source=self._source
                )
            self._open(scan)
        except (OSError, ValueError, struct.error) as error:
            self._file.close()
            raise self._unreadable(error) from error
        except LogError:
            self._file.close()
            raise

    def _unreadable(self, error: Exception) -> LogError:
        return LogError(f"cannot be read: {getattr(error, 'strerror', None) or error}", source=self._source)

    @property
    def _source(self) -> str:
        return f"log {str(self.path)!r}"

    @property
    def most_text(self) -> int | None:
        """Limit on the bytes of JSON in one message; None where there is none."""
        return self._limits.text(self._size)

    def check_records(self, number: int) -> None:
        """Refuse an index of more messages than a file of this size can hold."""
        self._limits.records(number, self._size)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def chunk_count(self) -> int:
        """Return the number of chunks that can be read."""
        return len(self.places)

    @property
    def size(self) -> int:
        """Bytes of the file."""
        return self._size

    def messages(self, chunk: int) -> list[RawMessage]:
        """Return the messages of one chunk after checking its CRC."""
        known = self._cache.get(chunk)
        if known is None:
            offset, length = self.places[chunk]
            known = self._parse_messages(self._chunk_content(offset, length), length)
            self._cache[chunk] = known
            self._cached_bytes += _bytes_held(known)
            self._forget()
        self._cache.move_to_end(chunk)
        return known

    def all_messages(self) -> Iterator[tuple[int, RawMessage]]:
        """Yield the messages of all chunks in order, each with the number of its chunk."""
        for chunk in range(self.chunk_count):
            for message in self.messages(chunk):
                yield chunk, message

    def metadata(self) -> list[tuple[str, dict[str, str]]]:
        """Return the Metadata records that the summary names: name and texts of each."""
        found = []
        for offset, length in self._metadata:
            opcode, body = next(self._records(memoryview(self._read(offset, length))), (0, memoryview(b"")))
            if opcode != Opcode.METADATA:
                raise self._damage_error("a Metadata record")
            record = self._parse(Metadata, body, "a Metadata record")
            found.append((record.name, record.metadata))
        return found

    def _parse(self, kind: type[McapRecord], body: memoryview | bytes, what: str) -> Any:
        """Return a small record as the `mcap` package reads it; `LogError` where it cannot."""
        try:
            return kind.read(ReadDataStream(BytesIO(body)))  # type: ignore[attr-defined] - each kind has it, their base has not
        except (EndOfFile, struct.error, UnicodeDecodeError) as error:
            raise self._damage_error(what) from error

    def _forget(self) -> None:
        while self._cached_bytes > _CACHE_BYTES and len(self._cache) > 1:
            self._cached_bytes -= _bytes_held(self._cache.popitem(last=False)[1])

    # -- finding chunks ---------------------------------------------------------------------------------------------

    def _open(self, scan: bool) -> None:
        if self._read(0, len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise LogError("no MCAP file", expected="a log of granular-env", source=f"{str(self.path)!r}")
        self._check_profile()
        footer = None if scan else self._footer()
        self.complete = footer is not None
        if footer is None:
            self.places = list(self._scan())
            self.bytes_lost = self._size - self._scanned
            return
        start, summary = footer
        self.places = []
        for opcode, body in self._records(memoryview(summary)):
            if opcode == _CHANNEL_OP:
                self._add_channel(body)
            elif opcode == Opcode.CHUNK_INDEX:
                # A long log has thousands of these: the package takes five times as long.
                _, _, offset, length = _CHUNK_INDEX.unpack_from(body)
                self.places.append((offset, length))
            elif opcode == Opcode.METADATA_INDEX:
                place = self._parse(MetadataIndex, body, "the index of Metadata records")
                self._metadata.append((place.offset, place.length))
        self._check_places(start)

    def _check_profile(self) -> None:
        """Refuse other programs' files before any chunk of theirs is decompressed."""
        opcode, length = _RECORD.unpack(self._read(len(MCAP0_MAGIC), _RECORD.size))
        begin = len(MCAP0_MAGIC) + _RECORD.size
        head = self._read(begin, min(length, _HEADER_BYTES, self._size - begin))
        if opcode != Opcode.HEADER or self._parse(Header, head, "the header").profile != PROFILE:
            raise LogError(NOT_A_LOG, source=f"{str(self.path)!r}")

    def _footer(self) -> tuple[int, bytes] | None:
        """Return where the summary starts and its bytes; None where the file has no end."""
        end = self._size - len(MCAP0_MAGIC) - _FOOTER_BYTES
        if end < len(MCAP0_MAGIC) or self._read(self._size - len(MCAP0_MAGIC), len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            return None
        tail = self._read(end, _FOOTER_BYTES)
        opcode, length = _RECORD.unpack_from(tail)
        footer = self._parse(Footer, tail[_RECORD.size :], "the footer")
        start = footer.summary_start
        if opcode != Opcode.FOOTER or length != _FOOTER_BODY or not len(MCAP0_MAGIC) <= start <= end:
            raise self._damage_error("the footer")
        summary = self._read(start, end - start)
        if zlib.crc32(tail[:-4], zlib.crc32(summary)) != footer.summary_crc:
            raise self._damage_error("the summary")
        return start, summary

    def _check_places(self, end: int) -> None:
        before = len(MCAP0_MAGIC)
        for offset, length in self.places:
            if offset < before or length < _RECORD.size or offset + length > end:
                raise self._damage_error("the index of chunks")
            before = offset + length

    def _scan(self) -> Iterator[tuple[int, int]]:
        """Chunks from the front, as long as they are whole."""
        offset = len(MCAP0_MAGIC)
        while offset + _RECORD.size <= self._size:
            self._scanned = offset
            opcode, length = _RECORD.unpack(self._read(offset, _RECORD.size))
            total = _RECORD.size + length
            if offset + total > self._size:
                self.damage = f"the record at byte {offset} is cut off"
                return
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                self._scanned = self._size
                return
            if opcode == Opcode.CHUNK:
                try:
                    self._parse_messages(self._chunk_content(offset, total), total)
                except LogError as error:
                    fault = error.faults[0]
                    self.damage, self.advice = replace(fault, hint="").text(), fault.hint if fault.hint != _RECOVER else ""
                    return
                yield offset, total
            elif not 1 <= opcode <= 15:
                self.damage = f"the record at byte {offset} is of no known kind"
                return
            offset += total
        self._scanned = offset

    # -- reading chunks ---------------------------------------------------------------------------------------------

    def _chunk_content(self, offset: int, length: int) -> bytes:
        data = self._read(offset, length)
        place = f"the chunk at byte {offset}"
        opcode, body_length = _RECORD.unpack_from(data)
        head = _RECORD.size + _CHUNK.size
        if opcode != Opcode.CHUNK or body_length != length - _RECORD.size or length < head + 8:
            raise self._damage_error(place)
        _, _, size, crc, name_length = _CHUNK.unpack_from(data, _RECORD.size)
        name = data[head : head + name_length]
        begin = head + name_length + 8
        if begin > length or struct.unpack_from("<Q", data, begin - 8)[0] != length - begin:
            raise self._damage_error(place)
        self._limits.chunk(size)
        content = self._decompress(memoryview(data)[begin:], name, size, place)
        if crc == 0 or zlib.crc32(content) != crc:
            raise self._damage_error(place)
        return content

    def _decompress(self, data: memoryview, name: bytes, size: int, place: str) -> bytes:
        if name == b"":
            content = bytes(data)
        elif name == b"lz4":
            import lz4.frame

            try:
                # One byte more than declared is enough to notice a bomb, and all that it may unfold to.
                content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
            except (RuntimeError, ValueError, EOFError, OverflowError, MemoryError) as error:
                raise self._damage_error(place) from error
        else:
            raise LogError(
                f"{place} is compressed with {name[:20]!r}",
                hint="logs of granular-env use lz4",
                source=f"log {str(self.path)!r}",
            )
        if len(content) != size:
            raise self._damage_error(place)
        return content

    def _parse_messages(self, content: bytes, compressed: int) -> list[RawMessage]:
        messages = []
        for number, (opcode, body) in enumerate(self._records(memoryview(content))):
            self._limits.records(number, compressed)
            if opcode == _CHANNEL_OP:
                self._add_channel(body)
            elif opcode == _MESSAGE_OP:
                if len(body) < _MESSAGE.size:
                    raise self._damage_error("a message")
                channel, sequence, *times = _MESSAGE.unpack_from(body)
                if channel not in self._channels:
                    raise self._damage_error("a message of an unknown channel")
                messages.append(RawMessage(self._channels[channel], sequence, times[0], times[1], body[_MESSAGE.size :]))
        return messages

    def _add_channel(self, body: memoryview) -> None:
        channel = self._parse(Channel, body, "a channel")
        if self._channels.setdefault(channel.id, channel.topic) != channel.topic:
            raise self._damage_error("a channel with two topics")

    def _records(self, view: memoryview) -> Iterator[tuple[int, memoryview]]:
        offset = 0
        while offset < len(view):
            if offset + _RECORD.size > len(view):
                raise self._damage_error("a record")
            opcode, length = _RECORD.unpack_from(view, offset)
            offset += _RECORD.size
            if offset + length > len(view):
                raise self._damage_error("a record")
            yield opcode, view[offset : offset + length]
            offset += length

    def _read(self, offset: int, length: int) -> bytes:
        if offset + length > self._size:
            raise self._damage_error("its end")
        self._file.seek(offset)
        data = self._file.read(length)
        if len(data) != length:
            raise self._damage_error(f"what follows byte {offset}")
        return data

    def _damage_error(self, what: str) -> LogError:
        damage = f"log {str(self.path)!r} is damaged: {what} is not what was written"
        return LogError(Fault(received=damage, hint=_RECOVER))


def _bytes_held(messages: list[RawMessage]) -> int:
    return sum(len(message.data) + _OBJECT_BYTES for message in messages)


def _open_regular(path: Path) -> IO[bytes]:
    """Open a file for reading; a pipe or a device, which might make the program wait for ever, is refused."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(0, "it is a folder, a device or a pipe; give the path of a file")
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise
