"""The file under a recorder: whole chunks of about a megabyte, an index of every message, errors that name the path."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ...components.errors import LogError, ParameterError
from ...output_files import advice_for
from ..container import PROFILE
from ..container.writer import McapWriter, Part
from ..format import protobuf
from ..format.metadata import METADATA_NAME
from ..format.records import COLUMNS, HEADER, KINDS, TOPICS, Record, encode, log_identity
from ..preview.messages import PreviewMessage, Topic
from .log_file import LogFile, SyncError

CHUNK_BYTES = 1 << 20
# The first chunks are smaller, so that of a short log of which the end is lost not all is lost [bytes]; then an eighth of
# what has been written.
_FIRST_CHUNK_BYTES, _CHUNK_SHARE = 1 << 16, 8
# Writers whose files are open. The garbage collector, which closes files in any order, must not come to one before the dropped
# recorder that closes it properly.
_OPEN: set[LogWriter] = set()
_SAVE_THE_REST = "What was written until then can be opened, and `granular-env recover` makes it a complete log"


class LogWriter:
    """Writes records to an MCAP file. One thread only; after an error nothing more is written."""

    def __init__(self, path: Path, file: LogFile, advice: str = _SAVE_THE_REST) -> None:
        """Write the head of the file; `advice` ends the message of an error."""
        self.path, self._file, self._advice = path, file, advice
        self.log = ""
        self._rows: list[tuple[int, ...]] = []
        self._numbers = [0] * len(KINDS)
        self._sequences: dict[str, int] = {}
        self._chunk = self._unfinished_bytes = self._bytes = self._latest = 0
        self._failed: LogError | None = None
        self._topics = list(TOPICS)
        _OPEN.add(self)
        try:
            self._run_guarded(self._start)
        except LogError:
            self.abandon()
            raise

    def _start(self) -> None:
        self._writer = writer = McapWriter(self._file, PROFILE, PROFILE)
        block = writer.add_schema("granular.Block", "protobuf", protobuf.block_schema())
        self._channels = {topic: writer.add_channel(topic, "protobuf", block) for topic in TOPICS}
        self._schemas: dict[str, int] = {}

    def number(self, kind: int) -> int:
        """Return the number that the next record of a kind has to carry."""
        return self._numbers[kind]

    @property
    def rows(self) -> np.ndarray:
        """The index so far, shape (messages, columns), int64."""
        return np.array(self._rows, dtype=np.int64).reshape(-1, len(COLUMNS))

    def add(self, record: Record, nanoseconds: int) -> None:
        """Write one record; a full chunk is ended and flushed.

        A message that follows a later one in the file bears that one's time: readers find the messages in the order of time.
        """
        parts = encode(record, self.log)
        if record.kind == HEADER:
            self.log = log_identity(b"".join(parts))
        self._rows.append((*record.row, self._chunk))
        self._numbers[record.kind] += 1
        self._latest = max(self._latest, nanoseconds)
        self._add_message(self._topics[record.kind], parts, self._latest)

    def add_metadata(self, texts: dict[str, str]) -> None:
        """Write the Metadata record that stock tools show."""
        self._run_guarded(lambda: self._writer.add_metadata(METADATA_NAME, texts))

    def add_preview(self, messages: Iterable[PreviewMessage]) -> None:
        """Write what stock viewers draw, in chunks of its own."""
        self.flush()
        for message in messages:
            if message.topic.name not in self._channels:
                self._run_guarded(partial(self._add_channel, message.topic))
            self._add_message(message.topic.name, message.parts, message.log_time, message.publish_time)
        self.flush()

    def _add_channel(self, topic: Topic) -> None:
        if topic.schema not in self._schemas:
            self._schemas[topic.schema] = self._writer.add_schema(topic.schema, topic.encoding, topic.definition)
        schema = self._schemas[topic.schema]
        self._channels[topic.name] = self._writer.add_channel(topic.name, topic.message_encoding, schema)

    def _add_message(self, topic: str, parts: Sequence[Part], nanoseconds: int, publish_time: int | None = None) -> None:
        sequence = self._sequences.get(topic, 0)
        self._sequences[topic] = sequence + 1
        size = sum(map(len, parts))
        self._unfinished_bytes += size
        self._bytes += size
        place = self._channels[topic], sequence & 0xFFFFFFFF, nanoseconds
        self._run_guarded(lambda: self._writer.add_message(*place, parts, publish_time))
        if self._unfinished_bytes >= min(CHUNK_BYTES, max(_FIRST_CHUNK_BYTES, self._bytes // _CHUNK_SHARE)):
            self.flush()

    def flush(self) -> None:
        """End the chunk and hand everything to the operating system."""
        if self._unfinished_bytes:
            self._run_guarded(self._writer.flush)
            self._chunk += 1
            self._unfinished_bytes = 0

    def finish(self) -> None:
        """End the file with the summary that makes it complete, and close it."""
        try:
            self.flush()
            self._run_guarded(self._writer.finish)
            self._run_guarded(self._file.sync)
            self.publish()
        finally:
            self.abandon()

    def publish(self) -> None:
        """Put the file in the place of the older log that it replaces, if it does."""
        if not self._file.published:
            self._run_guarded(self._file.publish)

    @property
    def published(self) -> bool:
        """Return whether the file stands under its own name."""
        return self._file.published

    def abandon(self) -> None:
        """Close the file as it is; one that was not published is removed."""
        try:
            self._file.close()
        except OSError:
            # What could not be written has been reported already, by the write itself.
            pass
        finally:
            _OPEN.discard(self)

    def _run_guarded(self, write) -> None:  # noqa: ANN001
        if self._failed is not None:
            raise self._failed
        try:
            write()
        except (OSError, ValueError) as error:
            self._failed = self._explain(error)
            raise self._failed from error

    def _explain(self, error: Exception) -> LogError:
        reason, came = getattr(error, "strerror", None) or str(error), f"log {str(self.path)!r}"
        if not self.published:
            hint = f"{advice_for(error)}. The log that stood there is kept"
            return LogError(f"{came} cannot be written any more: {reason}", hint=hint)
        if isinstance(error, SyncError):
            hint = "copy it to another disk; if it is incomplete, `granular-env recover` makes it whole"
            return LogError(f"{came}: its disk did not confirm that it has what was written: {reason}", hint=hint)
        return LogError(f"{came} cannot be written any more: {reason}", hint=f"{advice_for(error)}. {self._advice}")


def as_path(path: str | os.PathLike[str]) -> Path:
    """Return a path argument, or raise where it is not a path."""
    try:
        return Path(path)
    except TypeError:
        raise ParameterError(f"got {path!r}", expected="the name of a file", at="path") from None
