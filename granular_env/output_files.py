"""Writing files completely or not at all, and never over a device or a folder."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any

from .components.errors import GranularError, ParameterError


@contextmanager
def replace_file(
    path: str | os.PathLike[str], kind: type[GranularError] = GranularError, folder: bool = False
) -> Iterator[Path]:
    """Open a new file next to `path`, which replaces `path` if the block succeeds and is deleted if it fails.

        with replace_file("scene.rrd") as part:
            part.write_bytes(data)

    The folder is created if necessary. Through a symbolic link its target is replaced. With `folder`, the block fills a new
    folder, which replaces a folder.

    Raises:
        ParameterError: the path exists and is not a regular file.
        GranularError: of class `kind`; the disk is full, or the folder is not writable.
    """
    try:
        target = Path(path).absolute() if folder else require_writable(path, kind)
        target.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".", suffix=".part", dir=target.parent) as hidden:
            part = Path(hidden, "part")
            part.mkdir() if folder else part.touch()
            yield part
            if folder:
                shutil.rmtree(target, ignore_errors=True)
            else:
                with open(part, "rb") as file:
                    os.fsync(file.fileno())  # otherwise a power cut could leave the renamed file empty
            os.replace(part, target)
    except OSError as error:
        raise _unwritable_error(path, error, kind) from error


def write_error_hint(error: BaseException) -> str:
    """Return the hint for a file that cannot be written."""
    if getattr(error, "errno", None) in (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)):
        return "free some space or choose another folder"
    return "choose another path"


def write_files(contents: Mapping[Path, bytes], kind: type[GranularError] = GranularError) -> None:
    """Write all of several files or none; errors as in `replace_file`."""
    with ExitStack() as stack:
        for path, data in contents.items():
            stack.enter_context(replace_file(path, kind)).write_bytes(data)


def lock_file(file: IO[Any], refusal: GranularError) -> None:
    """Lock an open file for this process until the file is closed or the process ends for any reason.

    Raises:
        GranularError: `refusal`, if another process has locked the file.
        OSError: the file system does not support locks.
    """
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise refusal from None


def resolve_file(path: str | os.PathLike[str]) -> Path:
    """Return the target of a path, links followed; `ParameterError` for a folder, a device or a pipe."""
    try:
        target = Path(os.path.realpath(path))
    except ValueError as error:
        raise ParameterError(f"{os.fspath(path)!r} is not a valid path: {error}", at="path") from None
    # Not Path.exists, which raises for names that are too long.
    if os.path.exists(target) and not os.path.isfile(target):
        what = "a folder" if os.path.isdir(target) else "a device, a pipe or a socket"
        raise ParameterError(f"{os.fspath(path)!r} is {what}", hint="give the path of a file to write", at="path")
    return target


def require_writable(path: str | os.PathLike[str], kind: type[GranularError] = GranularError) -> Path:
    """Return the target of a path, links followed, if its folder is writable or can be created; create nothing.

    Long computations call this first, so that a wrong path is reported before the work.

    Raises:
        ParameterError: the path is not a regular file, or the name contains a zero byte.
        GranularError: of class `kind`; the folder is not writable.
    """
    target = resolve_file(path)
    folder = next(folder for folder in target.parents if os.path.exists(folder))
    if not folder.is_dir():
        raise _unwritable_error(path, NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR)), kind)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise _unwritable_error(path, PermissionError(errno.EACCES, os.strerror(errno.EACCES)), kind)
    return target


def _unwritable_error(path: str | os.PathLike[str], error: OSError, kind: type[GranularError]) -> GranularError:
    """Return the error for a file that cannot be written, with advice for its cause."""
    reason = error.strerror or error
    return kind(f"{os.fspath(path)!r} cannot be written: {reason}; {write_error_hint(error)}; an existing file is kept")


def valid_file_name(name: str, default: str) -> str:
    """Return a valid name for a file or a folder, or `default` if no character is left."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")[:100] or default


def count_text(number: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun: "1 frame", "2 frames"; `plural` is an irregular plural."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def size_text(size: int) -> str:
    """Return a size in words: "512 bytes", "1.5 MB", "1.53 GB"."""
    for unit, scale in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return count_text(size, "byte")
