"""Writer of the file of a log: one writer per file, complete chunks, and an index of all messages."""

from __future__ import annotations

import contextlib
import fcntl
import os
import secrets
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from ..components.errors import LogError, ParameterError
from ..output_files import resolve_file, write_error_hint
from .header import METADATA_NAME, make_metadata
from .preview.encoding import own_schema
from .preview.film import PreviewMessage, Topic
from .records import CLOSED, COLUMNS, FRAMES, HEADER, INCIDENTS, KINDS, PROFILE, Record, encode_record, record_topic

CHUNK_BYTES = 1 << 20
# Size of the first chunks [bytes]: small, so that a short log that is cut off is not lost completely; later chunks have an
# eighth of the size of all chunks before them.
_FIRST_CHUNK_BYTES, _CHUNK_SHARE = 1 << 16, 8


class LogWriter:
    """A writer of records to an MCAP file, for one thread only; after an error nothing more is written.

    A file that replaces an older log is written under a hidden name until `publish` is called.

    Attributes:
        path: the log's name once it is published.
        rows: the index so far, one row per record.
        published: whether the log has this name.
    """

    def __init__(self, path: str | os.PathLike[str], overwrite: bool = False, is_hidden: bool = False) -> None:
        """Start a file.

        Args:
            path: name of the log; its folder is created if necessary.
            overwrite: whether an existing log, or an empty file, may be replaced.
            is_hidden: whether to use a hidden name even if `path` does not exist.

        Raises:
            ParameterError: the existing file may not be replaced, or another recorder is writing it.
            LogError: the file cannot be written.
        """
        self.path = to_path(path)
        self._file, self._part, self._older = _create_file(self.path, overwrite, is_hidden)
        self.rows: list[tuple[int, ...]] = []
        self._numbers = [0] * len(KINDS)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._variables: Any = []
        self._chunk = self._unfinished_bytes = self._bytes = self._latest = 0
        self._failed: LogError | None = None
        # Let only `flush` end a chunk, not the mcap library, so that the index knows the chunk of each record.
        self._mcap = Writer(self._file, chunk_size=2**62, compression=CompressionType.LZ4)
        with self._translate_errors():
            self._mcap.start(PROFILE, PROFILE)

    def add_record(self, record: Record, nanoseconds: int) -> None:
        """Write a record; end and flush a full chunk.

        A record with an earlier time than the one before it gets that one's time, because readers require the order of time.
        """
        record = replace(record, number=self._numbers[record.kind])
        if record.kind == HEADER:
            self._variables = record.header["variables"]
        self.rows.append((*record.row, self._chunk))
        self._numbers[record.kind] += 1
        self._latest = max(self._latest, nanoseconds)
        facts = self._variables[record.detail] if record.kind == FRAMES else {"name": ""}
        schema = "granular.Frames" if record.kind == FRAMES else "granular.Block"
        texts = {name: str(facts[name]) for name in ("unit", "shape", "description") if name in facts}
        topic = Topic(record_topic(record.kind, facts["name"]), schema, "protobuf", own_schema(schema), texts)
        self._add_message(topic, record.number, encode_record(record), self._latest, self._latest)

    def add_header(self, record: Record) -> None:
        """Write the first record, and the Metadata record for stock tools."""
        self.add_record(record, 0)
        self.flush()
        with self._translate_errors():
            self._mcap.add_metadata(METADATA_NAME, make_metadata(record.header))
            self._mcap.flush()

    def add_preview(self, messages: Iterable[PreviewMessage]) -> None:
        """Write the preview (the messages that viewers such as Foxglove show), in chunks of its own."""
        self.flush()
        for number, one in enumerate(messages):
            self._add_message(one.topic, number, one.data, one.log_time, one.publish_time)
        self.flush()

    def _add_message(self, topic: Topic, number: int, data: bytes, log_time: int, time: int) -> None:
        with self._translate_errors():
            if topic.schema not in self._schemas:
                self._schemas[topic.schema] = self._mcap.register_schema(topic.schema, topic.encoding, topic.definition)
            if topic.name not in self._channels:
                facts = topic.message_encoding, self._schemas[topic.schema], dict(topic.metadata)
                self._channels[topic.name] = self._mcap.register_channel(topic.name, *facts)
            self._mcap.add_message(self._channels[topic.name], log_time, data, time, number & 0xFFFFFFFF)
        self._unfinished_bytes += len(data)
        self._bytes += len(data)
        if self._unfinished_bytes >= min(CHUNK_BYTES, max(_FIRST_CHUNK_BYTES, self._bytes // _CHUNK_SHARE)):
            self.flush()

    def flush(self) -> None:
        """End the chunk and pass all data to the operating system, so that SIGKILL loses nothing added before."""
        if self._unfinished_bytes:
            with self._translate_errors():
                self._mcap.flush()
            self._chunk += 1
            self._unfinished_bytes = 0

    def finish(self, segment: int, tick: int, nanoseconds: int, facts: dict[str, Any]) -> None:
        """Write the closing record and the summary that completes the file, sync the disk, and close the file.

        The log ends at a tick of a segment; `facts` are the report, conclusions and cautions of the run.
        """
        try:
            index = np.array(self.rows, dtype=np.int64).reshape(-1, len(COLUMNS))
            closed = Record(INCIDENTS, CLOSED, segment, tick, tick, 1, 0, {"incident": "closed", **facts}, {"index": index})
            self.add_record(closed, nanoseconds)
            self.flush()
            with self._translate_errors():
                self._mcap.finish()
                self._file.flush()
                os.fsync(self._file.fileno())
            self.publish()
        finally:
            self.abandon()

    @property
    def is_published(self) -> bool:
        """Return whether the file has the name of the log instead of a hidden name."""
        return self._part is None

    def publish(self) -> None:
        """Give the file the name of the log; this replaces the older log, if there is one."""
        if self._part is not None:
            with self._translate_errors():
                os.replace(self._part, self.path.resolve())
            self._part = None
            self._release_older_log()

    def abandon(self) -> None:
        """Close the file in its present state; remove an unpublished file and keep the older log."""
        # Ignore errors here: the write that failed has already reported its own.
        with contextlib.suppress(OSError):
            self._file.close()
        if self._part is not None:
            self._part.unlink(missing_ok=True)
        self._release_older_log()

    def _release_older_log(self) -> None:
        if self._older is not None:
            self._older.close()
            self._older = None

    @contextlib.contextmanager
    def _translate_errors(self) -> Iterator[None]:
        """Turn the first error of the file into a `LogError` with its name, and raise the same error from then on."""
        if self._failed is not None:
            raise self._failed
        try:
            yield
        except (OSError, ValueError) as error:
            rest = "The part written so far can be opened, and `granular-env recover` completes it"
            hint = f"{write_error_hint(error)}. {rest if self.is_published else 'The existing file is kept'}"
            reason = getattr(error, "strerror", None) or str(error)
            self._failed = LogError(f"log {str(self.path)!r} cannot be written any more: {reason}", hint=hint)
            self.abandon()
            raise self._failed from error


def to_path(path: str | os.PathLike[str]) -> Path:
    """Return a path argument, or raise if it is not a path."""
    try:
        return Path(path)
    except TypeError:
        raise ParameterError(f"got {path!r}", expected="the name of a file", at="path") from None


def _create_file(path: Path, overwrite: bool, is_hidden: bool) -> tuple[IO[bytes], Path | None, IO[bytes] | None]:
    """Return a new file, its hidden name (if any), and the older log that it will replace, all locked; see `LogWriter`."""
    source = f"log {str(path)!r}"
    try:
        target = resolve_file(path)
        if os.path.lexists(path) and not overwrite:
            hint = "choose another name, or pass overwrite=True (--overwrite)"
            raise ParameterError("it exists", hint=hint, source=source)
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{secrets.token_hex(8)}.part")
        if not os.path.exists(target):
            return _lock_file(open(part if is_hidden else target, "xb"), path), part if is_hidden else None, None
        with open(target, "rb") as file:
            head = file.read(len(MCAP0_MAGIC))
        if head and head != MCAP0_MAGIC:
            came = "the existing file is not a log, and only logs are replaced"
            raise ParameterError(came, hint="choose another name", source=source)
        older = _lock_file(open(target, "r+b"), path)
        return (_lock_file(open(part, "xb"), path), part, older) if head else (older, None, None)
    except ParameterError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise LogError(f"{source} cannot be written: {reason}", hint=write_error_hint(error)) from error


def _lock_file(file: IO[bytes], path: Path) -> IO[bytes]:
    """Lock a file for this writer until it is closed, unless the file system does not support locks."""
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        hint = "choose another name, or close the recorder that writes it"
        raise ParameterError("another recorder is writing it", hint=hint, source=f"log {str(path)!r}") from None
    except OSError:
        pass
    return file
