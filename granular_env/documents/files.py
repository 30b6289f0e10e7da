"""Finding of TOML and CSV files by a shipped name or a path, and reading of them."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from granular_env.components.csv_history import LARGEST_FILE, read_limited_file
from granular_env.components.errors import ExperimentError, one_line
from granular_env.package_contents import shipped_files

_LARGEST_FILE = 16 * 2**20


def find_file(source: Any, kind: str, shelf: str) -> Path:
    """Return the file for a path, or for a shipped name of kind `shelf` (see `shipped_files`); messages call it a `kind`.

    Raises:
        ExperimentError: the file does not exist.
    """
    if not isinstance(source, str | os.PathLike):
        raise ExperimentError(f"got {one_line(source, 60)}", expected="a name or a path", at=kind)
    path, shipped = Path(source), shipped_files(shelf)
    if os.path.isfile(path):
        if is_log(path):
            raise ExperimentError("this is a log", hint="try `granular-env check` or `granular-env report`", source=str(path))
        return path
    if str(source) in shipped:
        return shipped[str(source)]
    if os.path.isdir(path):
        raise ExperimentError("it is a folder", expected="a TOML file or a name of `granular-env list`", source=str(path))
    if path.suffix == ".toml":
        hint = "paths are relative to the current folder; `granular-env list` lists all shipped names"
        raise ExperimentError("there is no such file", hint=hint, source=str(path))
    advice = nearest_name_hint(str(source), shipped)
    raise ExperimentError(f"no {kind} is named {one_line(str(source), 60)}", hint=advice)


def read_data_file(path: Path) -> bytes:
    """Return the bytes of a CSV file named in a document; `ExperimentError` if it cannot be read."""
    try:
        return read_limited_file(path, LARGEST_FILE, "reduce the number of samples", ExperimentError)
    except ExperimentError:
        raise
    except (OSError, ValueError) as error:
        hint = "paths are relative to the experiment file"
        raise ExperimentError(f"the CSV file cannot be read: {error}", hint=hint, source=str(path)) from None


def is_log(path: str | Path) -> bool:
    """Return whether a path is a file that starts with the signature of a log."""
    from mcap.writer import MCAP0_MAGIC

    if os.path.isfile(path):
        with suppress(OSError), open(path, "rb") as file:
            return file.read(len(MCAP0_MAGIC)) == MCAP0_MAGIC
    return False


def nearest_name_hint(name: str, names: Iterable[str]) -> str:
    """Return the hint for an unknown name; the last part of a name suffices: `3.4-piston` for `nesterenko-1983/3.4-piston`."""
    known_as = {one: one for one in names}
    known_as |= {one.rpartition("/")[2]: one for one in known_as}
    close = [name] if name in known_as else difflib.get_close_matches(name, known_as, n=1, cutoff=0.6)
    return f"did you mean {known_as[close[0]]!r}?" if close else "`granular-env list` lists all names"


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; `ExperimentError` with the line of a syntax error."""
    data = read_limited_file(path, _LARGEST_FILE, "put long histories into a CSV file", ExperimentError)
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError, ArithmeticError) as error:
        raise ExperimentError(f"not valid TOML: {error}", source=str(path)) from None
