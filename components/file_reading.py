"""Reading files that people name: regular ones only, and never more than a limit."""

from __future__ import annotations

import stat
from pathlib import Path

from .errors import GranularError, ParameterError


def read_bounded(path: Path, largest: int, advice: str, kind: type[GranularError] = ParameterError) -> bytes:
    """Return the content of a regular file of at most `largest` bytes.

    Raises:
        GranularError: of that `kind`; it is a folder, a device or a pipe, or too large; `advice` says what to do then.
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, a pipe or a socket"
        raise kind(f"{path}: it is {what}, expected a file")
    with path.open("rb") as file:
        data = file.read(largest + 1)
    if len(data) > largest:
        raise kind(f"{path}: it has more than {largest} bytes; {advice}")
    return data
