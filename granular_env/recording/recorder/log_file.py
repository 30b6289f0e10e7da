"""The file of a log while it is written: one writer for each file, and an older log stays until the new one has begun."""

from __future__ import annotations

import contextlib
import fcntl
import gc
import os
import secrets
import threading
from pathlib import Path
from typing import IO, Any

from mcap.writer import MCAP0_MAGIC

from ...components.errors import Fault, LogError, Option, ParameterError
from ...output_files import advice_for, resolve_file

# Bytes after which the disk begins to take what was written.
_SYNC_BYTES = 16 << 20


class SyncError(OSError):
    """The disk did not confirm what it was given: nobody knows how much of the file is on it."""


class LogFile:
    """A file opened for one writer.

    Where it replaces an older log it is written beside that one, under a hidden name, until `publish` is called.

    Attributes:
        path: where the log stands once it is published.
        published: whether it stands there.
    """

    def __init__(self, path: Path, file: IO[bytes], part: Path | None = None, older: IO[bytes] | None = None) -> None:
        """Take the locked file; `part` is its hidden name, `older` the locked file that it will replace."""
        self.path, self._file, self._part, self._older = path, file, part, older
        self._unsynced = 0
        self._syncing: threading.Thread | None = None
        self._sync_error: OSError | None = None

    @property
    def published(self) -> bool:
        """Return whether it stands under its own name."""
        return self._part is None

    def write(self, data: Any) -> int:
        """Write bytes."""
        count = self._file.write(data)
        self._unsynced += count
        return count

    def flush(self) -> None:
        """Hand what was written to the operating system; of a long log the disk takes it meanwhile, so the end is short.

        Raises:
            SyncError: the disk failed to take what it was given before.
        """
        self._file.flush()
        self._tell_sync_error()
        if self._unsynced > _SYNC_BYTES and (self._syncing is None or not self._syncing.is_alive()):
            self._unsynced = 0
            self._syncing = threading.Thread(target=self._sync, name=f"granular-env disk {self.path}", daemon=True)
            # None can be started while the interpreter ends.
            with contextlib.suppress(RuntimeError):
                self._syncing.start()

    def publish(self) -> None:
        """Put it in the place of the older log; nothing where it stands there already."""
        if self._part is not None:
            os.replace(self._part, self.path)
            self._part = None
            self._release_older()

    def sync(self) -> None:
        """Wait until the disk has it; `SyncError` where it fails to take it."""
        self._file.flush()
        self._await_disk()
        self._sync()
        self._tell_sync_error()

    def _tell_sync_error(self) -> None:
        if self._sync_error is not None:
            raise SyncError(*self._sync_error.args) from self._sync_error

    def _await_disk(self) -> None:
        if self._syncing is not None and self._syncing.is_alive():
            self._syncing.join()

    def _sync(self) -> None:
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            # The system tells it once only.
            self._sync_error = self._sync_error or error

    def close(self) -> None:
        """Close it. One that was not published is removed, and the older log stays."""
        try:
            self._await_disk()
            _unlock(self._file)
            self._file.close()
        finally:
            if self._part is not None:
                self._part.unlink(missing_ok=True)
            self._release_older()

    def _release_older(self) -> None:
        if self._older is not None:
            self._older.close()
            self._older = None


def create(path: Path, overwrite: bool) -> LogFile:
    """Return a fresh file for a log at `path`, its folder made if need be.

    Args:
        path: where the log is to stand.
        overwrite: whether an existing log, or an empty file, may be replaced.

    Raises:
        ParameterError: something stands there that may not be replaced, or another recorder is writing it.
        LogError: the file cannot be written.
    """
    try:
        target = resolve_file(path)
        if os.path.lexists(path) and not overwrite:
            raise _existing(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            return LogFile(target, _lock(open(target, "xb"), path))
        except FileExistsError:
            return _replacement(path, target, overwrite)
    except ParameterError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise LogError(f"log {str(path)!r} cannot be written: {reason}", hint=advice_for(error)) from error


def _existing(path: Path) -> ParameterError:
    hint = ("choose another name, or pass ", Option("overwrite"))
    return ParameterError(Fault(("path",), f"{str(path)!r} exists", hint=hint))


def refuse_unless_log(path: Path) -> None:
    """Raise `ParameterError` where a file stands at `path` that is neither a log nor empty: no option replaces that."""
    if os.path.isfile(path):
        with open(path, "rb") as file:
            _check_is_log(file, path)


def _replacement(path: Path, target: Path, overwrite: bool) -> LogFile:
    if not overwrite:
        raise _existing(path)
    older = _open_older(path, target)
    try:
        if not _check_is_log(older, path):
            # An empty file has nothing that could be lost.
            return LogFile(target, older)
        part = target.with_name(f".{secrets.token_hex(8)}.part")
        return LogFile(target, _lock(open(part, "xb"), path), part, older)
    except BaseException:
        older.close()
        raise


def _open_older(path: Path, target: Path) -> IO[bytes]:
    """Open what stands there, locked; another writer may just have put its own in that place, then open that one."""
    while True:
        older = _lock(open(target, "r+b"), path)
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(older.fileno()), os.stat(target)):
                return older
        older.close()


def _check_is_log(file: IO[bytes], path: Path) -> bool:
    """Return whether it is a log, and False for an empty file; refuse everything else."""
    head = file.read(len(MCAP0_MAGIC))
    file.seek(0)
    if head and head != MCAP0_MAGIC:
        raise ParameterError(f"{str(path)!r} is no log, and only a log is replaced", hint="choose another name", at="path")
    return bool(head)


def _lock(file: IO[bytes], path: Path) -> IO[bytes]:
    try:
        try:
            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            gc.collect()  # a recorder that was dropped unclosed holds its lock until it is collected with its component
            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise ParameterError(
            f"{str(path)!r} is being written by another recorder",
            hint="choose another name, or wait until it is closed",
            at="path",
        ) from None
    except OSError:
        pass  # a file system without locks
    return file


def _unlock(file: IO[bytes]) -> None:
    """Give the lock back at once: a forked process may still have the file open."""
    with contextlib.suppress(OSError, ValueError):
        fcntl.flock(file.fileno(), fcntl.LOCK_UN)
