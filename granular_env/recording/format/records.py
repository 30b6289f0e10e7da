"""The records of a log: the names of its topics, and the self-checking block that is the content of each message.

A log is an MCAP file. Its exact content is in the topics ``granular/...``: each message is one block of
`support.serialization` that knows which log, which kind, which segment, which ticks and which number in its kind's sequence
it is, so that a message that is missing, doubled, moved or from another log is noticed. A *segment* is an unbroken history: it
begins with a reset or a restore, and with a snapshot.

===========  ==========================================================================================================
header       the first message: component, parameters, experiment, versions, machine, what is recorded
snapshots    the state at the start of each segment, there with the events before it, at key ticks and at the end
steps        for many calls of `step`: their lengths in ticks and the inputs that were set
frames       for one variable: ticks (m,) and values (m, ...)
hashes       at key ticks: a digest of each state variable and of the whole state, and the inputs then held
events       what happened to the component: rows of tick, kind, index, value and limit
incidents    what happened to the run: failures, a recovery; at the end one that says "closed", with the index of all messages
===========  ==========================================================================================================

Further topics, and a Metadata record, are for stock viewers and are not read back: see `preview` and `metadata`.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...components.errors import Location, LogError
from ...components.support.serialization import digest, pack_parts, unpack

FORMAT = 3
KINDS = ("header", "snapshots", "steps", "frames", "hashes", "events", "incidents")
HEADER, SNAPSHOTS, STEPS, FRAMES, HASHES, EVENTS, INCIDENTS = range(len(KINDS))
TOPICS = {f"granular/{name}": kind for kind, name in enumerate(KINDS)}
# Column `detail` of the index, for a snapshot; for frames it holds the number of the variable, for incidents CLOSED or 0.
START, KEY, END = 0, 1, 2
CLOSED = 1
# Columns of the index, one row a message.
COLUMNS = ("kind", "detail", "segment", "first", "last", "count", "number", "chunk")
_PLACE = COLUMNS[1:7]
# What is to be said of a record that does not hold what it should.
DAMAGED = "the log is damaged"
# The last time that readers with signed numbers can hold, as a float [ns].
_LAST_NANOSECOND = float(2**63 - 1024)


@dataclass(frozen=True, slots=True)
class Record:
    """One message of the exact content.

    Attributes:
        kind: one of the numbers above.
        detail: for frames the number of the variable, for snapshots START, KEY or END, for incidents CLOSED or 0.
        segment: which unbroken history.
        first, last: the ticks that it spans.
        count: how many steps, frames or rows it holds.
        number: place among the records of its kind.
        header: plain JSON values.
        arrays: name -> array, of one that is only written also its bytes in pieces.
    """

    kind: int
    detail: int
    segment: int
    first: int
    last: int
    count: int
    number: int
    header: Mapping[str, Any]
    arrays: Mapping[str, Any]

    @property
    def row(self) -> tuple[int, ...]:
        """Return what the index says of it, but for the chunk."""
        return (self.kind, self.detail, self.segment, self.first, self.last, self.count, self.number)


def encode(record: Record, log: str) -> list[bytes | memoryview]:
    """Return the message in parts: a protobuf message with one bytes field, so that stock tools can at least name it."""
    place = [getattr(record, name) for name in _PLACE]
    parts = pack_parts({"log": log, "kind": KINDS[record.kind], "place": place, "content": dict(record.header)}, record.arrays)
    return [b"\x0a" + varint(sum(map(len, parts))), *parts]


def decode(data: bytes | memoryview, kind: int, log: str | None, most_text: int | None = None) -> Record:
    """Return the record in a message.

    Args:
        data: the message.
        kind: what it has to be.
        log: the identity of the log that it has to belong to; None for the first message.
        most_text: limit on the bytes of its JSON text.

    Raises:
        LogError: `encode` did not write that for this log and this kind.
    """
    header, arrays = unpack(_unwrap(memoryview(data)), most_text)
    if not isinstance(header, dict) or header.get("kind") != KINDS[kind]:
        raise LogError("a message is of another kind", hint=f"{DAMAGED}, or was put together from others", at=KINDS[kind])
    place, content = header.get("place"), header.get("content")
    whole = isinstance(place, list) and len(place) == len(_PLACE) and all(type(x) is int and -1 <= x < 2**62 for x in place)
    if not whole or not isinstance(content, dict):
        raise damage("a message does not say where in the log it belongs", KINDS[kind])
    if log is not None and header.get("log") != log:
        raise LogError("a message belongs to another log", hint="this file was put together from several", at=KINDS[kind])
    return Record(kind, *place, content, arrays)  # type: ignore[misc]


def damage(received: str, at: str | Location, log: object = "") -> LogError:
    """Return the error for a part of a log that `record` does not write like that.

    Args:
        received: what is wrong with it.
        at: what holds it: "header", "index", one of the kinds of records, and the place there.
        log: its path, where that is known.
    """
    return LogError(received, hint=DAMAGED, at=at, source=f"log {str(log)!r}" if log else "")


def log_identity(header_message: bytes | memoryview) -> str:
    """Return the digest of the first message, which ties every message to its log."""
    return digest(header_message).hex()


def nanoseconds(ticks: int, step_size: float) -> int:
    """Return the time of a message in an MCAP file: an unsigned 64-bit number, at its end where a time lies beyond."""
    return round(min(ticks * step_size * 1e9, _LAST_NANOSECOND))


def words(values: np.ndarray | float) -> bytes:
    """Return the bits of a number or an array, for comparing and hashing."""
    return np.ascontiguousarray(values).tobytes()


def varint(value: int) -> bytes:
    """Encode a protobuf number."""
    parts = bytearray()
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    parts.append(value)
    return bytes(parts)


def _unwrap(data: memoryview) -> memoryview:
    if len(data) < 2 or data[0] != 0x0A:
        raise LogError("a message is no block of granular-env", hint=DAMAGED)
    length = shift = 0
    for offset in range(1, min(len(data), 11)):
        length |= (data[offset] & 0x7F) << shift
        shift += 7
        if data[offset] < 0x80:
            if length != len(data) - offset - 1:
                break
            return data[offset + 1 :]
    raise LogError("a message has a wrong length", hint=DAMAGED)


def bits(value: float) -> int:
    """Return the 64 bits of a number, so that -0.0 and 0.0 are told apart."""
    return struct.unpack("<q", struct.pack("<d", value))[0]
