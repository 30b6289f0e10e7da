"""Reading files that people name: regular ones only, and never more than a cap."""

from __future__ import annotations

import re
import stat
from pathlib import Path

from granular_env.components.errors import ExperimentError

# Keys of a TOML file are a few parts long; tomllib takes quadratic time over a key of thousands.
_LONGEST_KEY = 64
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+"""
_LONG_KEY = re.compile(rf"""(?<![\w"'.-])(?:{_PART}){{{_LONGEST_KEY}}}""")


def read_bounded(path: Path, largest: int, advice: str) -> bytes:
    """The content of a regular file of at most `largest` bytes.

    Raises:
        ExperimentError: it is a folder, a device or a pipe, or too large; `advice` says what to do then.
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, a pipe or a socket"
        raise ExperimentError(f"{path}: it is {what}, expected a file")
    with path.open("rb") as file:
        data = file.read(largest + 1)
    if len(data) > largest:
        raise ExperimentError(f"{path}: it has more than {largest} bytes; {advice}")
    return data


def refuse_long_keys(where: object, text: str) -> None:
    """`ExperimentError` with the place and line of a dotted key of more parts than any experiment has."""
    found = _LONG_KEY.search(text)
    if found is not None:
        line = text.count("\n", 0, found.start()) + 1
        raise ExperimentError(f"{where}: line {line}: a key of more than {_LONGEST_KEY} parts; keys have a few")
