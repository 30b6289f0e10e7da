"""The records of a log (its messages, except those for viewers): their topics, and their conversion to and from bytes.

A log is an MCAP file. Its exact content is in the topics ``granular/...``. A *segment* is an uninterrupted history that starts
with a reset or a restore, and with a snapshot. A *tick* is one internal step; `schedule` chooses the key ticks.

====================  =================================================================================================
granular/header       the first message: component, parameters, experiment, versions, machine, recorded variables
granular/snapshots    the state at the start of each segment (with the earlier events), at key ticks and at the end
granular/steps        for many calls of `step`: lengths in ticks and the inputs that were set
granular/frames/NAME  for one variable: ticks and values
granular/hashes       at key ticks: a digest of each state variable, of the whole state, and of the inputs in effect
granular/events       events of the component: rows of tick, kind, index, value and limit
granular/incidents    incidents of the recording: failures, a recovery; at the end "closed", with the index of all messages
====================  =================================================================================================

Frames are protobuf messages ``granular.Frames``, readable by any protobuf library; unit and shape are in the metadata of their
channel. All other messages are a block of `support.serialization` in a protobuf message ``granular.Block``. Further topics and
a Metadata record are for stock viewers and are not read back: see `preview` and `header.make_metadata`.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..components.component import Component
from ..components.errors import Location, LogError
from ..components.inputs import Held
from ..components.profiles import CompiledProfile
from ..components.support.serialization import digest, pack_parts, unpack

# The MCAP profile named in the header of the file, and the version of the content of a log.
PROFILE, FORMAT = "granular-env", 4
KINDS = ("header", "snapshots", "steps", "frames", "hashes", "events", "incidents")
HEADER, SNAPSHOTS, STEPS, FRAMES, HASHES, EVENTS, INCIDENTS = range(len(KINDS))
_FRAMES_TOPIC = "granular/frames/"
_KINDS_BY_TOPIC = {f"granular/{name}": kind for kind, name in enumerate(KINDS)}
# Values of the index column `detail`: START, KEY, END for snapshots, CLOSED or 0 for incidents, a variable's number for frames.
START, KEY, END = 0, 1, 2
CLOSED = 1
# Columns of the index, with one row per message.
COLUMNS = ("kind", "detail", "segment", "first", "last", "count", "number", "chunk")
_PLACE = COLUMNS[1:7]
DAMAGED = "the log is damaged"
# The largest message time [ns], as a float; other programs may read it as a signed 64-bit integer.
_LAST_NANOSECOND = float(2**63 - 1024)


@dataclass(frozen=True, slots=True)
class Record:
    """A message of the log's exact content, that is, of the topics ``granular/...``.

    Attributes:
        kind: kind of the record, one of the constants above.
        detail: for frames the number of the variable, for snapshots START, KEY or END, for incidents CLOSED or 0.
        segment: number of the segment.
        first, last: first and last tick.
        count: number of steps, frames or rows.
        number: position among the records of its kind; set by the writer.
        header: plain JSON values; none for frames.
        arrays: by name; the values of frames to be written may be a list with one array per frame.
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
        """The record's row in the index, without the column for the chunk."""
        return (self.kind, self.detail, self.segment, self.first, self.last, self.count, self.number)


def record_topic(kind: int, variable: str = "") -> str:
    """Return the topic of records of a kind; `variable` is the variable of frames."""
    return _FRAMES_TOPIC + variable if kind == FRAMES else f"granular/{KINDS[kind]}"


def record_kind(topic: str) -> int | None:
    """Return the kind of the records in a topic; None for topics of the preview."""
    return FRAMES if topic.startswith(_FRAMES_TOPIC) else _KINDS_BY_TOPIC.get(topic)


def encode_record(record: Record) -> bytes:
    """Return a record as the bytes of a message."""
    place = [getattr(record, name) for name in _PLACE]
    if record.kind == FRAMES:
        # Join the frames that a recorder collected only here, in the writing thread, because copying large frames takes time.
        values = record.arrays["values"]
        parts: list[Any] = []
        for number, field in enumerate(([np.array(place)], [record.arrays["ticks"]], values), 1):
            arrays = [np.ascontiguousarray(one) for one in (field if isinstance(field, list) else [field])]
            parts += [_field_head(number, sum(one.nbytes for one in arrays)), *(one.data for one in arrays)]
        return b"".join(parts)
    parts = pack_parts({"kind": KINDS[record.kind], "place": place, "content": dict(record.header)}, record.arrays)
    return b"".join([_field_head(1, sum(map(len, parts))), *parts])


def decode_record(data: bytes, kind: int, text_limit: int | None = None) -> Record:
    """Return the record in a message whose topic states its kind; its JSON text has at most `text_limit` bytes.

    Raises:
        LogError: not a message that `encode_record` writes for this kind.
    """
    header: Any = {}
    if kind == FRAMES:
        fields = _packed_fields(data)
        if len(fields) != 3 or any(len(field) % 8 for field in fields):
            raise LogError("a message does not have the layout that granular-env writes", hint=DAMAGED)
        place, ticks, values = fields[0].view("<i8").tolist(), fields[1].view("<i8"), fields[2].view("<f8")
        arrays = {"ticks": ticks, "values": values}
    else:
        block = next(iter(_packed_fields(data)), np.zeros(0, np.uint8))
        content, arrays = unpack(block.data, text_limit)
        if not isinstance(content, dict) or content.get("kind") != KINDS[kind]:
            raise LogError("a message has the wrong kind", hint=f"{DAMAGED}, or combines parts of several logs", at=KINDS[kind])
        place, header = content.get("place"), content.get("content")
    whole = isinstance(place, list) and len(place) == len(_PLACE) and all(type(x) is int and -1 <= x < 2**62 for x in place)
    if not whole or not isinstance(header, dict):
        raise damage_error("the position of a message in the log is invalid", KINDS[kind])
    return Record(kind, *place, header, arrays)  # type: ignore[misc]


def damage_error(received: str, at: str | Location, log: object = "") -> LogError:
    """Return the error for content of a log, at the location `at`, that `record` cannot have written."""
    return LogError(received, hint=DAMAGED, at=at, source=f"log {str(log)!r}" if log else "")


def to_nanoseconds(ticks: int, step_size: float) -> int:
    """Return the message time [ns] of a tick, at most `_LAST_NANOSECOND` (MCAP stores an unsigned 64-bit integer)."""
    return round(min(ticks * step_size * 1e9, _LAST_NANOSECOND))


def encode_varint(value: int) -> bytes:
    """Encode a whole number as a protobuf varint."""
    parts = bytearray()
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*parts, value))


def _field_head(number: int, size: int) -> bytes:
    """Return the prefix of a protobuf field of bytes or packed numbers."""
    return encode_varint(number << 3 | 2) + encode_varint(size)


def _packed_fields(data: bytes) -> list[np.ndarray]:
    """Return the content of each field of a protobuf message (bytes or packed numbers; fields 1, 2, ...) as uint8 arrays."""
    view, found, offset = np.frombuffer(data, np.uint8), [], 0
    while offset < len(data):
        tag, length, begin = data[offset], 0, offset + 1
        for shift in range(0, 35, 7):
            byte = data[begin] if begin < len(data) else 0
            length, begin = length | (byte & 0x7F) << shift, begin + 1
            if byte < 0x80:
                break
        offset = begin + length
        if tag != len(found) + 1 << 3 | 2 or offset > len(data):
            raise LogError("a message does not have the layout that granular-env writes", hint=DAMAGED)
        found.append(view[begin:offset])
    return found


def value_bits(values: np.ndarray | float) -> bytes:
    """Return the bits of a number or an array as bytes, for bitwise comparison and hashing."""
    return np.ascontiguousarray(values).tobytes()


def input_word(value: Held) -> int:
    """Return a word for an input's value: the bits of a number (-0.0 differs from 0.0), or a hash of an array or a profile."""
    if isinstance(value, CompiledProfile):
        pattern = b"" if value.pattern is None else value.pattern.tobytes()
        return _digest_word(value.ticks.tobytes() + value.coefficients.tobytes() + pattern)
    return (
        _digest_word(value_bits(value)) if isinstance(value, np.ndarray) else struct.unpack("<q", struct.pack("<d", value))[0]
    )


def make_hash_row(component: Component, state: Iterable[str], inputs: Iterable[str]) -> np.ndarray:
    """Return the hashes stored at one tick, int64: one per state variable, one of the whole state, one per input in effect."""
    row = [_digest_word(value_bits(component.peek(name))) for name in state]
    row.append(_digest_word(component.state_view()))
    held = component.held_inputs
    row += [input_word(held[name]) for name in inputs]
    return np.array(row, dtype=np.int64)


def _digest_word(data: bytes | memoryview) -> int:
    return int.from_bytes(digest(data), "little", signed=True)
