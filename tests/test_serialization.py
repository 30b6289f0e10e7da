"""Conversion between bytes and arrays; damaged or hostile data raise only LogError."""

from __future__ import annotations

import json
import random
import struct
import zlib

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from granular_env.components.errors import LogError
from granular_env.components.oscillator import Oscillator
from granular_env.components.profiles import Profile
from granular_env.components.snapshot import Snapshot
from granular_env.components.support.serialization import VERSION, digest, pack, unpack

texts = st.text(st.characters(codec="utf-8"), max_size=10)
headers = st.dictionaries(
    texts, st.recursive(st.none() | st.booleans() | st.integers() | texts, st.lists, max_leaves=5), max_size=4
)
dtypes = st.sampled_from(["<f8", "<f4", "<i8", "<i4", "<u8", "<u4", "|u1"])
arrays = st.dictionaries(
    texts, dtypes.flatmap(lambda dtype: hnp.arrays(dtype, hnp.array_shapes(min_dims=0, min_side=0, max_side=4))), max_size=4
)


def sealed(content: object, data: bytes = b"", version: int = VERSION) -> bytes:
    """Return a block with a valid checksum and arbitrary content."""
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    return with_checksum(struct.pack("<4sHI", b"GRNL", version, len(text)) + text + data)


def with_checksum(body: bytes) -> bytes:
    """Return a block with a valid checksum whose fourth field gives the start of the arrays."""
    front = 10 + int.from_bytes(body[6:10], "little")
    return body + digest(body[:front] + struct.pack("<I", zlib.crc32(body[front:])))


@given(headers, arrays)
def test_round_trip_keeps_every_bit(header: dict, given_arrays: dict) -> None:
    found_header, found = unpack(pack(header, given_arrays))
    assert found_header == header
    assert found.keys() == given_arrays.keys()
    for name, array in given_arrays.items():
        assert found[name].dtype == array.dtype
        assert found[name].shape == array.shape
        assert found[name].tobytes() == array.tobytes()
        assert found[name].flags.writeable and found[name].base is None


def test_big_endian_and_strided_arrays_are_stored_by_value() -> None:
    strided = np.arange(12.0).reshape(3, 4)[:, ::2]
    _, found = unpack(pack({}, {"strided": strided, "big": np.arange(3, dtype=">i4")}))
    np.testing.assert_array_equal(found["strided"], strided)
    np.testing.assert_array_equal(found["big"], [0, 1, 2])


@pytest.mark.parametrize(
    "cut",
    [
        0,
        9,
        40,
        -1,
    ],
)
def test_truncated_blocks_are_refused(cut: int) -> None:
    with pytest.raises(LogError):
        unpack(pack({"a": 1}, {"x": np.arange(5.0)})[:cut])


def test_a_later_version_says_so() -> None:
    with pytest.raises(LogError, match="version 7.*update"):
        unpack(sealed({}, version=7))
    with pytest.raises(LogError, match="version 1.*older"):
        unpack(sealed({}, version=1))


@pytest.mark.parametrize(
    "content",
    [
        {},
        7,
        b"\xff\xfe",
        b"[" * 100_000,
        {"header": {}, "arrays": 3},
        {"header": {}, "arrays": [["x"]]},
        {"header": {}, "arrays": [["x", "|O", [1]]]},
        {"header": {}, "arrays": [["x", "<f8", [-1]]]},
        {"header": {}, "arrays": [["x", "<f8", [1]]]},
        {"header": {}, "arrays": [["x", "<f8", [2**40, 2**40]]]},
        {"header": {}, "arrays": [["x", "<f8", [0, 2**300]]]},
        {"header": {}, "arrays": [["x", "<f8", [2**40] * 100_000]]},
        {"header": {}, "arrays": [[["x"], "<f8", [0]]]},
    ],
)
def test_hostile_content_with_a_valid_checksum_is_refused(content: object) -> None:
    with pytest.raises(LogError):
        unpack(sealed(content))


# -- snapshots --------------------------------------------------------------------------------------------------------


def moving() -> Oscillator:
    oscillator = Oscillator(step_size=0.01)
    oscillator.reset(position=0.5)
    oscillator.step(0.2, force=Profile.triangle(3.0, 0.1))
    return oscillator


def test_snapshots_survive_bytes() -> None:
    oscillator = moving()
    snapshot = Snapshot.from_bytes(oscillator.save().to_bytes())
    assert snapshot.to_bytes() == oscillator.save().to_bytes()
    assert (snapshot.identity, snapshot.tick) == (oscillator.identity, 20)
    oscillator.step(0.1)
    expected = oscillator.save().to_bytes()
    oscillator.restore(snapshot)
    oscillator.step(0.1)
    assert oscillator.save().to_bytes() == expected


def test_a_snapshot_is_not_changed_by_what_follows() -> None:
    oscillator = moving()
    snapshot = oscillator.save()
    before = snapshot.to_bytes()
    oscillator.step(0.1, force=1.0)
    oscillator.restore(snapshot)
    oscillator.step(0.1, force=2.0)
    oscillator.reset()
    assert snapshot.to_bytes() == before


def snapshot_parts() -> tuple[dict, dict]:
    return unpack(moving().save().to_bytes())


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("kind", "frame"),
        ("tick", -1),
        ("tick", 2**70),
        ("identity", 3),
        ("inputs", {"force": 3.0}),
        ("inputs", {"force": "fast"}),
        ("inputs", {"force": "0x1p99999"}),
        ("profiles", {"other": "0x1p-3"}),
        ("profiles", {"force": 3}),
    ],
)
def test_wrong_snapshot_headers_are_refused(key: str, value: object) -> None:
    header, blocks = snapshot_parts()
    with pytest.raises(LogError):
        Snapshot.from_bytes(pack({**header, key: value}, blocks))
    del header[key]
    with pytest.raises(LogError):
        Snapshot.from_bytes(pack(header, blocks))


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("memory", np.zeros(6)),
        ("memory", np.zeros((6, 1), dtype=np.int64)),
        ("force.ticks", np.array([3, 3])),
        ("force.ticks", np.array([5, 3])),
        ("force.ticks", np.array([[1]])),
        ("force.coefficients", np.zeros((2, 0))),
        ("force.coefficients", np.zeros((2, 100))),
        ("force.coefficients", np.full((2, 2), np.nan)),
    ],
)
def test_wrong_snapshot_arrays_are_refused(name: str, array: np.ndarray) -> None:
    header, blocks = snapshot_parts()
    with pytest.raises(LogError):
        Snapshot.from_bytes(pack(header, {**blocks, name: array}))
    del blocks[name]
    with pytest.raises(LogError):
        Snapshot.from_bytes(pack(header, blocks))


def mutated(data: bytes, random: random.Random) -> bytes:
    """Return data with one to three changes: bits flipped, bytes overwritten, cut, duplicated or inserted."""
    block = bytearray(data)
    for _ in range(random.randint(1, 3)):
        place = random.randrange(len(block))
        kind = random.randrange(5)
        if kind == 0:
            block[place] ^= 1 << random.randrange(8)
        elif kind == 1:
            block[place : place + 4] = random.randbytes(4)
        elif kind == 2:
            del block[place : place + random.randint(1, 20)]
        elif kind == 3:
            block[place:place] = block[place : place + random.randint(1, 20)]
        else:
            block[place:place] = random.randbytes(random.randint(1, 8))
        if not block:
            break
    return bytes(block)


@pytest.mark.parametrize("seed", range(4))
def test_mutations_with_a_mended_checksum_give_a_snapshot_or_a_log_error(seed: int) -> None:
    """Forged data: the only error is LogError, and accepted data are a well-formed snapshot."""
    data, generator = moving().save().to_bytes(), random.Random(seed)
    accepted = 0
    for _ in range(500):
        body = mutated(data[:-8], generator)
        try:
            snapshot = Snapshot.from_bytes(with_checksum(body))
        except LogError:
            continue
        accepted += 1
        assert snapshot.memory.ndim == 1 and snapshot.tick >= 0
        assert Snapshot.from_bytes(snapshot.to_bytes()).to_bytes() == snapshot.to_bytes()
    assert 0 < accepted < 500
