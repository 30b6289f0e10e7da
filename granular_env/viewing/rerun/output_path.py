"""The path of a rerun file to write, checked: nothing but a rerun file is ever replaced by one."""

from __future__ import annotations

import os
from pathlib import Path

from granular_env.components.errors import GranularError, ParameterError
from granular_env.output_files import require_writable

# The first bytes of every rerun file; the version that follows them differs.
_MAGIC = b"RRF"


def rerun_target(path: str | os.PathLike[str]) -> Path:
    """Return a path to write a rerun file to, or raise.

    Raises:
        ParameterError: its name does not end in .rrd, or what stands there (a log, say) is no rerun file.
        GranularError: what stands there cannot be read, or no file can be written there.
    """
    try:
        name = os.fspath(path)
    except TypeError:
        raise ParameterError(f"got {path!r}", expected="the path of a file", at="path") from None
    there = require_writable(path)
    if Path(name).suffix.lower() != ".rrd":
        raise ParameterError(f"got {name!r}", expected="the name of a rerun file, which ends in .rrd", at="path")
    if not os.path.exists(there):
        return Path(path)
    try:
        # An empty file holds nothing to lose.
        with there.open("rb") as file:
            first = file.read(len(_MAGIC))
    except OSError as error:
        raise GranularError(f"{name!r} cannot be read: {error.strerror or error}", hint="choose another name") from error
    if first not in (b"", _MAGIC):
        raise ParameterError(
            f"{name!r} exists and is no rerun file, so it is not replaced", hint="choose another name", at="path"
        )
    return Path(path)
