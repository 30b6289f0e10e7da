"""Conversion of arrays and JSON values to bytes and back: the format of snapshots and of every record in a log.

Layout: magic ``GRNL``, version (u16), length of the JSON header (u32), the header, then the arrays' bytes in order, then a
checksum: 8 bytes of BLAKE2b over the part before the arrays and the CRC-32 of the arrays (u32). The header lists each array's
name, dtype and shape. Only numbers are stored: bytes from an untrusted source can raise `LogError` but never run code, and
never cause allocations larger than the data.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..errors import LogError, one_line

MAGIC = b"GRNL"
VERSION = 2
_HEAD, _CRC = struct.Struct("<4sHI"), struct.Struct("<I")
_DIGEST_SIZE = 8
_MAXIMUM_DIMENSIONS = 8
_DAMAGED = "the data is damaged"
# Little-endian numbers only, the byte order of x86-64 machines.
_DTYPES = {"<f8", "<f4", "<i8", "<i4", "<u8", "<u4", "|u1"}


def digest(data: bytes | memoryview) -> bytes:
    """Return an 8-byte BLAKE2b hash."""
    return hashlib.blake2b(data, digest_size=_DIGEST_SIZE).digest()


def canonical_json(value: Any) -> bytes:
    """Return JSON with sorted keys, no spaces and floats in their shortest exact form; refuse NaN and infinity."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def pack(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return one self-checking block of bytes from a JSON-able header and named arrays."""
    return b"".join(pack_parts(header, arrays))


def pack_parts(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> list[bytes | memoryview]:
    """Return the parts that `pack` joins. Arrays are not copied: do not change them before the parts are written."""
    listed: list[list[Any]] = []
    parts: list[bytes | memoryview] = []
    for name, array in arrays.items():
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        # Use the shape of the given array: ascontiguousarray makes a scalar one-dimensional.
        listed.append([name, little.dtype.str, list(np.shape(array))])
        parts.append(little.reshape(-1).view(np.uint8).data)
    text = canonical_json({"header": header, "arrays": listed})
    front = _HEAD.pack(MAGIC, VERSION, len(text)) + text
    return [front, *parts, _checksum(front, parts)]


def _checksum(front: bytes | memoryview, parts: Iterable[bytes | memoryview]) -> bytes:
    """Return the checksum of a block; the large arrays enter by CRC-32, which takes a fifth of the time of BLAKE2b."""
    crc = 0
    for part in parts:
        crc = zlib.crc32(part, crc)
    return digest(bytes(front) + _CRC.pack(crc))


def unpack(data: bytes | memoryview, text_limit: int | None = None) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return header and arrays (new, writable) of a block written by `pack`; raise `LogError` for anything else.

    Args:
        data: the block.
        text_limit: limit on the size of the JSON header in bytes: parsed JSON takes up to forty times its length.
    """
    if not isinstance(data, (bytes, bytearray, memoryview)):
        raise LogError(f"got {one_line(data)}", expected="the bytes of a packed block")
    try:
        return _unpack(memoryview(data).cast("B"), text_limit)
    except LogError:
        raise
    except (ValueError, KeyError, TypeError, IndexError, struct.error, RecursionError, OverflowError) as error:
        raise LogError(f"a packed block is not readable: {error}", hint=_DAMAGED) from error


def _unpack(view: memoryview, text_limit: int | None) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    if len(view) < _HEAD.size + _DIGEST_SIZE:
        raise LogError(f"got {len(view)} bytes, too few for a packed block", hint="it was cut off")
    magic, version, length = _HEAD.unpack_from(view)
    if magic != MAGIC:
        raise LogError(
            f"a packed block starts with {bytes(magic)!r}", expected=f"{MAGIC!r}", hint="this is not data of granular-env"
        )
    if version != VERSION:
        raise LogError(
            f"a packed block has format version {version}, this program reads {VERSION}",
            hint="update granular-env" if version > VERSION else "an older granular-env wrote it; record it again",
        )
    body, stored = view[:-_DIGEST_SIZE], bytes(view[-_DIGEST_SIZE:])
    if _HEAD.size + length > len(body):
        raise LogError("a packed block's header is longer than the block", hint=_DAMAGED)
    front = body[: _HEAD.size + length]
    if _checksum(front, [body[len(front) :]]) != stored:
        raise LogError("a packed block does not match its checksum", hint=_DAMAGED)
    if text_limit is not None and length > text_limit:
        raise LogError(f"a packed block's header has {length} bytes of text", expected=f"at most {text_limit}")
    content = json.loads(bytes(front[_HEAD.size :]))
    arrays: dict[str, np.ndarray] = {}
    offset = len(front)
    for name, dtype_name, shape in content["arrays"]:
        if dtype_name not in _DTYPES:
            raise LogError(f"got dtype {dtype_name!r}", at=("array", name), expected=f"one of {', '.join(sorted(_DTYPES))}")
        if len(shape) > _MAXIMUM_DIMENSIONS or any(not isinstance(extent, int) or not 0 <= extent < 2**48 for extent in shape):
            raise LogError(
                f"got shape {shape}", expected=f"at most {_MAXIMUM_DIMENSIONS} whole numbers from 0", at=("array", name)
            )
        dtype = np.dtype(dtype_name)
        count = 1
        for extent in shape:
            count *= extent
        size = count * dtype.itemsize
        if offset + size > len(body):
            raise LogError(
                f"it takes {size} bytes, but the block has {len(body) - offset} left", hint=_DAMAGED, at=("array", name)
            )
        arrays[name] = np.frombuffer(body[offset : offset + size], dtype=dtype).reshape(shape).copy()
        offset += size
    if offset != len(body):
        raise LogError(f"a packed block has {len(body) - offset} bytes that belong to no array", hint=_DAMAGED)
    return content["header"], arrays
