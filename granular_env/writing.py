"""Writing files that people name: whole or not at all, and never over a device or a folder."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from .components.errors import GranularError, ParameterError
from .terminal import printable


@contextmanager
def replacing(path: str | os.PathLike[str], kind: type[GranularError] = GranularError) -> Iterator[Path]:
    """A fresh file beside `path` to write to, which takes its place when the block ends well and is gone when it does not.

        with replacing("scene.rrd") as part:
            part.write_bytes(data)

    The folder is made if need be. A link stays one: the file that it leads to is replaced.

    Args:
        path: the file to write; what stands there is kept until the new one is whole.
        kind: class of the error.

    Raises:
        ParameterError: there is something that is no regular file.
        GranularError: of that `kind`; the disk is full, or the folder is not to be written to.
    """
    part: Path | None = None
    try:
        target = refused_unless_file(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{secrets.token_hex(8)}.part")
        part.touch(exist_ok=False)
        yield part
        _sync(part)
        os.replace(part, target)
    except OSError as error:
        raise kind(
            f"{os.fspath(path)!r} cannot be written: {error.strerror or error}; {advice_for(error)}; what stood there is kept"
        ) from error
    finally:
        if part is not None:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Wait until the disk has a file: after a power cut, one that was renamed before that could be found empty."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())


def advice_for(error: BaseException) -> str:
    """Return what to do about a file that cannot be written."""
    if getattr(error, "errno", None) in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return "free some space or choose another folder"
    return "choose a folder that you may write to"


def write_files(contents: Mapping[Path, bytes], kind: type[GranularError] = GranularError) -> None:
    """Write several files, all of them or none; errors as in `replacing`."""
    with ExitStack() as stack:
        for path, data in contents.items():
            stack.enter_context(replacing(path, kind)).write_bytes(data)


def refused_unless_file(path: str | os.PathLike[str]) -> Path:
    """Where a path leads, links followed; `ParameterError` where a folder, a device or a pipe stands there."""
    try:
        target = Path(os.path.realpath(path))
    except ValueError as error:
        raise ParameterError(f"{os.fspath(path)!r} is no path: {error}") from None
    # Not Path.exists: that one raises for names that are too long, which the writing itself will tell.
    if os.path.exists(target) and not os.path.isfile(target):
        what = "a folder" if os.path.isdir(target) else "a device, a pipe or a socket"
        raise ParameterError(f"{os.fspath(path)!r} is {what}; give the path of a file to write")
    return target


def with_article(name: object) -> str:
    """A noun with "a" or "an" before it; it may be a stranger's."""
    text = printable(name)
    return f"{'an' if text[:1].lower() in set('aeiou') else 'a'} {text}"


def counted(number: int, noun: str, plural: str = "") -> str:
    """A number and its noun: "1 frame", "2 frames"; `plural` where that is not the noun with an s."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def readable_bytes(size: int) -> str:
    """Return a size in words: "512 bytes", "1.5 MB", "1.53 GB"."""
    for unit, scale in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return counted(size, "byte")
