"""Logs designed to fill the memory, run endlessly, or cause errors other than GranularError are refused cheaply."""

from __future__ import annotations

import dataclasses
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
from mcap.writer import Writer
from support.hostile_logs import ACTIONS, count_refusals
from support.recording_helpers import chain_log, oscillator_log, rewrite_log
from support.work import count_calls

import granular_env.components.catalogue as catalogue
from granular_env.components.errors import LogError
from granular_env.recording import open_log, record, recover, verify
from granular_env.recording.index import CHUNK, COUNT, FIRST, KIND, LAST, SEGMENT
from granular_env.recording.records import FRAMES, HEADER, PROFILE, STEPS, Record

# -- sizes -------------------------------------------------------------------------------------------------------------


def _measured(act: Callable[[], object]) -> tuple[int, int]:
    """Return the peak memory [bytes] and the number of function calls until a refusal."""

    def refuse() -> None:
        with pytest.raises(LogError):
            act()

    tracemalloc.start()
    calls, peak = count_calls(refuse), tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak, calls


def _bomb(path: Path, profile: str, content: bytes) -> int:
    """Write a file with one chunk that expands to `content`; return its size."""
    with path.open("wb") as file:
        Writer(file).start(profile, "")
        head = struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content)) + struct.pack("<I", 3) + b"lz4"
        packed = lz4.frame.compress(content)
        body = head + struct.pack("<Q", len(packed)) + packed
        file.write(b"\x06" + struct.pack("<Q", len(body)) + body)
    return path.stat().st_size


def _empty_messages(number: int) -> bytes:
    channel = struct.pack("<HHI", 1, 0, 1) + b"x" + struct.pack("<I", 0) + struct.pack("<I", 0)
    message = b"\x05" + struct.pack("<Q", 22) + struct.pack("<HIQQ", 1, 0, 0, 0)
    return b"\x04" + struct.pack("<Q", len(channel)) + channel + message * number


@pytest.mark.parametrize("act", [open_log, verify, lambda path: recover(path, path.with_suffix(".out"))])
def test_a_chunk_full_of_empty_messages_is_refused_cheaply(tmp_path: Path, act: Callable[[Path], object]) -> None:
    """The chunk expands two hundredfold; objects for all messages would take another factor of ten."""
    content = _empty_messages(600_000)
    size = _bomb(tmp_path / "a.mcap", PROFILE, content)
    peak, calls = _measured(lambda: act(tmp_path / "a.mcap"))
    assert size < len(content) / 100
    # Each message that is read takes three calls.
    assert peak < 2 * len(content) + (8 << 20) and calls < 600_000


def test_another_programs_file_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    content = _empty_messages(600_000)
    _bomb(tmp_path / "a.mcap", "ros2", content)
    peak, _ = _measured(lambda: open_log(tmp_path / "a.mcap"))
    assert peak < 1 << 20


def test_a_long_text_in_a_record_is_not_parsed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of 20 kB expands to 1.5 MB of JSON, which would take forty times as much memory after parsing."""
    from granular_env.recording import container

    oscillator_log(tmp_path / "a.mcap")

    def change(old: Record) -> Record:
        return dataclasses.replace(old, header={**old.header, "experiment": [[]] * 500_000}) if old.kind == HEADER else old

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    assert (tmp_path / "b.mcap").stat().st_size < 100_000
    monkeypatch.setattr(container, "_TEXT_BYTES", 1 << 20)
    peak, _ = _measured(lambda: open_log(tmp_path / "b.mcap"))
    assert peak < 12 << 20
    assert len(open_log(tmp_path / "b.mcap", allow_large=True).metadata["experiment"]) == 500_000


# -- a false index, and other false contents with valid checksums ------------------------------------------------------


def _with_index(tmp_path: Path, change: Callable[[np.ndarray], np.ndarray]) -> Path:
    chain_log(tmp_path / "a.mcap", steps=20, every=6e-7, overwrite=True)

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change_index=change)
    return tmp_path / "b.mcap"


def _set(column: int, row: int, value: int) -> Callable[[np.ndarray], np.ndarray]:
    def change(rows: np.ndarray) -> np.ndarray:
        rows[row, column] = value
        return rows

    return change


def _all_counts(rows: np.ndarray) -> np.ndarray:
    """The sum of the sizes overflows to a small number."""
    frames = rows[:, KIND] == FRAMES
    rows[frames, COUNT] = 2**62
    return rows


@pytest.mark.parametrize(
    "change",
    [
        lambda rows: rows[::-1],
        lambda rows: np.concatenate([rows[:1], rows[:0:-1]]),
        _set(CHUNK, 3, 0),
        _set(KIND, 4, 99),
        _set(SEGMENT, 4, 5),
        _set(LAST, 2, 2**61),
        _set(FIRST, 2, -1),
        _set(COUNT, -1, 2**62),
        _all_counts,
    ],
)
def test_an_index_that_lies_is_refused(tmp_path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    path = _with_index(tmp_path, change)
    assert count_refusals(path) >= 2
    with pytest.raises(LogError):
        verify(path)


@pytest.mark.parametrize("last", [2**54, 2**61])
def test_ticks_that_no_run_reaches_are_refused(tmp_path: Path, last: int) -> None:
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap"):
        component.step(0.5)

    def change(old: Record) -> Record:
        if old.kind != STEPS:
            return old
        return dataclasses.replace(old, last=last, arrays={**old.arrays, "durations": np.array([last], dtype=np.int64)})

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    assert count_refusals(tmp_path / "b.mcap") == len(ACTIONS)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("versions", [1]),
        ("parameters", [1, 2]),
        ("experiment", {"a": [None, {"b": None}]}),
        ("parent", [[]]),
        ("drawables", [3]),
        ("drawables", [{"kind": "points"}]),
        ("balances", [{"quantity": 3}]),
        ("event_kinds", [1]),
        ("state", None),
    ],
)
def test_a_header_of_other_types_is_refused_or_harmless(tmp_path: Path, name: str, value: object) -> None:
    chain_log(tmp_path / "a.mcap", steps=4)

    def change(old: Record) -> Record:
        return dataclasses.replace(old, header={**old.header, name: value}) if old.kind == HEADER else old

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    count_refusals(tmp_path / "b.mcap")
