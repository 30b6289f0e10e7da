"""The `mcap` package's own writer and reader against ours, on the same messages."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from granular_env.recording.limits import Limits
from granular_env.recording.mcap_reader import McapReader
from granular_env.recording.mcap_writer import McapWriter

from .figures import Figure
from .timing import interleaved, ratio

# Messages of a chunk, as recordings have them: many small ones, or a single large one [bytes].
_CHUNK_BYTES = 1 << 20


def measure(small: int = 10_000, large: int = 60, large_words: int = 200_000, rounds: int = 5) -> Iterator[Figure]:
    """Writing and reading whole files of small and of large messages."""
    with TemporaryDirectory() as folder:
        random = np.random.default_rng(5)
        # Numbers that compress as those of a run do: half of their bytes are the same.
        for name, count, words in (("1 kB", small, 128), (f"{large_words * 8 / 1e6:g} MB", large, large_words)):
            data = (random.integers(0, 2**31, words) * 2**32).astype(np.int64).tobytes()
            yield from _compare(Path(folder), name, data, count, rounds)


def _compare(folder: Path, name: str, data: bytes, count: int, rounds: int) -> Iterator[Figure]:
    own, theirs = folder / "own.mcap", folder / "theirs.mcap"
    a_chunk = max(1, _CHUNK_BYTES // len(data))
    writing = interleaved(
        {"own": partial(_write_own, own, data, count, a_chunk), "mcap": partial(_write_theirs, theirs, data, count)}, rounds
    )
    reading = interleaved({"own": partial(_read_own, own, count), "mcap": partial(_read_theirs, own, count)}, rounds)
    for verb, times in (("writing", writing), ("reading", reading)):
        speed = count * len(data) / float(np.median(times["own"])) / 1e6
        note = f"{count} messages; ours {speed:.0f} MB/s"
        yield Figure(f"mcap's own {verb} of messages of {name}, time over ours", ratio(times["mcap"], times["own"]), note=note)


def _write_own(path: Path, data: bytes, count: int, a_chunk: int) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file, "granular-env", "")
        channel = writer.add_channel("topic", "any", writer.add_schema("schema", "any", b""))
        for number in range(count):
            writer.add_message(channel, number, number, [data])
            if number % a_chunk == a_chunk - 1:
                writer.flush()
        writer.finish()


def _write_theirs(path: Path, data: bytes, count: int) -> None:
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4)
        writer.start("granular-env", "")
        channel = writer.register_channel("topic", "any", writer.register_schema("schema", "any", b""))
        for number in range(count):
            writer.add_message(channel, number, data, number, number)
        writer.finish()


def _read_own(path: Path, count: int) -> None:
    reader = McapReader(path, Limits(str(path)))
    found = sum(len(reader.messages(chunk)) for chunk in range(reader.chunk_count))
    reader.close()
    assert found == count


def _read_theirs(path: Path, count: int) -> None:
    with path.open("rb") as file:
        assert sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)) == count
