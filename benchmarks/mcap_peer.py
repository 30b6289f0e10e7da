"""The `mcap` package's own reader against ours, which believes no size before it has checked it."""

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
from granular_env.recording.records import PROFILE

from .figures import Figure
from .timing import interleaved, ratio

# Messages of a chunk, as recordings have them: many small ones, or a single large one [bytes].
_CHUNK_BYTES = 1 << 20


def measure(small: int = 10_000, large: int = 60, large_words: int = 200_000, rounds: int = 5) -> Iterator[Figure]:
    """Reading whole files of small and of large messages, with all checksums."""
    with TemporaryDirectory() as folder:
        path, random = Path(folder) / "a.mcap", np.random.default_rng(5)
        for name, count, words in (("1 kB", small, 128), (f"{large_words * 8 / 1e6:g} MB", large, large_words)):
            # Half of their bytes are zero: they compress as the numbers of a run do.
            data = (random.integers(0, 2**31, words) * 2**32).astype(np.int64).tobytes()
            _write(path, data, count)
            times = interleaved({"own": partial(_read_own, path, count), "mcap": partial(_read_theirs, path, count)}, rounds)
            note = f"{count} messages; ours {count * len(data) / float(np.median(times['own'])) / 1e6:.0f} MB/s"
            yield Figure(
                f"mcap's own reader, messages of {name}, time over ours", ratio(times["mcap"], times["own"]), note=note
            )


def _write(path: Path, data: bytes, count: int) -> None:
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4)
        writer.start(PROFILE, "")
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
