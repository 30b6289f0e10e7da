"""The `mcap` package's own writer and reader against ours, on the same messages."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from granular_env.recording.container import PROFILE
from granular_env.recording.container.limits import Limits
from granular_env.recording.container.reader import McapReader
from granular_env.recording.container.writer import McapWriter, Part

from .figures import Figure
from .timing import interleaved, ratio

# Messages of a chunk, as recordings have them: many small ones, or a single large one [bytes].
_CHUNK_BYTES = 1 << 20


def measure(small: int = 10_000, large: int = 60, large_words: int = 200_000, rounds: int = 5) -> Iterator[Figure]:
    """Writing messages that come in parts, as those of a recorder do, and reading them with all checksums: whole files."""
    with TemporaryDirectory() as folder:
        random = np.random.default_rng(5)
        for name, count, words in (("1 kB", small, 128), (f"{large_words * 8 / 1e6:g} MB", large, large_words)):
            # Positions and velocities compress by a tenth: so does one word in ten that is zero.
            numbers = np.where(np.arange(words) % 10, random.random(words), 0.0)
            yield from _compare(Path(folder), name, [bytes(64), numbers.view(np.uint8).data], count, rounds)


def _compare(folder: Path, name: str, parts: list[Part], count: int, rounds: int) -> Iterator[Figure]:
    own, theirs = folder / "own.mcap", folder / "theirs.mcap"
    size = sum(map(len, parts))
    a_chunk = max(1, _CHUNK_BYTES // size)
    write = {"own": partial(_write_own, own, parts, count, a_chunk), "mcap": partial(_write_theirs, theirs, parts, count)}
    read = {"own": partial(_read_own, own, count), "mcap": partial(_read_theirs, own, count)}
    # Neither of them collects what the other one left.
    writing, reading = (interleaved(calls, rounds, gc.collect) for calls in (write, read))
    for verb, times in (("writing", writing), ("reading", reading)):
        note = f"{count} messages; ours {count * size / float(np.median(times['own'])) / 1e6:.0f} MB/s"
        yield Figure(f"mcap's own {verb} of messages of {name}, time over ours", ratio(times["mcap"], times["own"]), note=note)


def _write_own(path: Path, parts: list[Part], count: int, a_chunk: int) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file, PROFILE, "")
        channel = writer.add_channel("topic", "any", writer.add_schema("schema", "any", b""))
        for number in range(count):
            writer.add_message(channel, number, number, parts)
            if number % a_chunk == a_chunk - 1:
                writer.flush()
        writer.finish()


def _write_theirs(path: Path, parts: list[Part], count: int) -> None:
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4)
        writer.start(PROFILE, "")
        channel = writer.register_channel("topic", "any", writer.register_schema("schema", "any", b""))
        for number in range(count):
            writer.add_message(channel, number, b"".join(parts), number, number)
        writer.finish()


def _read_own(path: Path, count: int) -> None:
    reader = McapReader(path, Limits(str(path)))
    found = sum(len(reader.messages(chunk)) for chunk in range(reader.chunk_count))
    reader.close()
    assert found == count


def _read_theirs(path: Path, count: int) -> None:
    with path.open("rb") as file:
        assert sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)) == count
