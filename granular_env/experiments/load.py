"""Finding and reading experiments: a shipped name, a file, or a dict; with single keys overridden."""

from __future__ import annotations

import copy
import difflib
import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from granular_env.components.errors import ExperimentError
from granular_env.components.files import read_bounded
from granular_env.shipped import shipped_files

from .faults import overridden, shortened
from .files import refuse_long_keys
from .schema import Experiment, known_keys, parse, refuse_unknown

Source = str | os.PathLike[str] | Mapping[str, Any] | Experiment

# The first bytes of every MCAP file.
_LOG_MAGIC = b"\x89MCAP"
_LARGEST_FILE = 16 * 2**20
# Keys of experiments: a sum of sums goes deepest, the name of an input is longest.
_MOST_PARTS, _LONGEST_PART = 32, 200
_BARE_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")


def shipped_experiments() -> list[str]:
    """Names of the experiments that come with the package, such as ``nesterenko-1983/3.4-piston``."""
    return list(shipped_files("experiments"))


def load_experiment(source: Source, overrides: Iterable[str] = (), folder: Path | None = None) -> Experiment:
    """An experiment, checked as far as that goes without building its component.

    Args:
        source: a shipped experiment's name, the path of a TOML file, the content of one as a dict, or an experiment.
        overrides: ``"a.b=value"`` each, the value as in TOML (a bare word is a string too): ``"duration=1e-3"``,
            ``"component.grains=500"``, ``"start.velocity.0=3"``, ``"stop.0.above=2"``.
        folder: where the files lie that a dict names; default: the current one.

    Raises:
        ExperimentError: file, table, key, what came and what was expected; unknown keys with the nearest right one.
    """
    overrides, before = override_list(overrides), ()
    if isinstance(source, Experiment):
        if not overrides:
            return source
        before = source.overrides
        document, origin, folder = source.to_dict(), source.origin, source.folder
    elif isinstance(source, Mapping):
        document, origin, folder = copy.deepcopy(dict(source)), "experiment", folder or Path()
    else:
        path = experiment_path(source)
        document, origin, folder = read_document(path), str(path), path.parent
    for override in overrides:
        _override(document, override)
    with overridden(origin, overrides):
        experiment = parse(document, origin, folder)
    experiment._overrides = (*before, *overrides)
    return experiment


def experiment_path(source: str | os.PathLike[str]) -> Path:
    """The file behind a shipped name or a path; `ExperimentError` where there is none."""
    try:
        path = Path(source)
        is_file = path.is_file()
    except (TypeError, ValueError, OSError) as error:
        raise ExperimentError(f"experiment {shortened(source)}: no name and no path: {error}") from None
    if is_file:
        _refuse_log(path)
        return path
    names = shipped_experiments()
    if str(source) in names:
        return shipped_files("experiments")[str(source)]
    if path.exists():
        what = "a folder" if path.is_dir() else "a device, a pipe or a socket"
        raise ExperimentError(f"{path}: it is {what}, expected a TOML file or a name of `granular-env list`")
    if path.suffix == ".toml":
        raise ExperimentError(f"{path}: there is no such file")
    raise ExperimentError(
        f"experiment {shortened(str(source))}: no shipped experiment and no file; {nearest_names(str(source), names)}"
    )


def _refuse_log(path: Path) -> None:
    """`ExperimentError` where a file is a log and no experiment; one that cannot be read is told of when it is."""
    if begins_as_log(path):
        raise ExperimentError(f"{path}: this is a log, try `granular-env check` or `granular-env report`")


def begins_as_log(path: Path) -> bool:
    """Return whether a file begins as logs do."""
    with suppress(OSError), path.open("rb") as file:
        return file.read(len(_LOG_MAGIC)) == _LOG_MAGIC
    return False


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Advice for a name that is not in the list: the right one if it is plain, else the nearest and where the list is."""
    names = sorted(known)
    short = {name.rpartition("/")[2]: name for name in names}
    close = [short[name]] if name in short else difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        return f"did you mean {close[0]!r}?"
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
    return f"the nearest: {', '.join(near)}; `granular-env list` names all"


def read_document(path: Path) -> dict[str, Any]:
    """The content of a TOML file; `ExperimentError` with the line where it is none."""
    try:
        text = read_bounded(path, _LARGEST_FILE, "put long histories into a CSV file", ExperimentError).decode("utf-8")
        refuse_long_keys(path, text)
        return tomllib.loads(text)
    except OSError as error:
        raise ExperimentError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise ExperimentError(f"{path}: byte {error.start} is no UTF-8 text; save the file as plain text") from None
    except tomllib.TOMLDecodeError as error:
        raise ExperimentError(f"{path}: not valid TOML: {error}") from None
    except (RecursionError, ValueError, ArithmeticError) as error:
        raise ExperimentError(f"{path}: not readable as TOML: {error}") from None


def override_list(overrides: Iterable[str]) -> list[str]:
    """Return overrides as a list; `ExperimentError` where they are no ``"key=value"`` texts."""
    expected = "expected a list of texts, such as ['component.grains=500']"
    if isinstance(overrides, str | Mapping) or not isinstance(overrides, Iterable):
        raise ExperimentError(f"overrides: got {shortened(overrides)}, {expected}")
    found = list(overrides)
    for place, override in enumerate(found):
        if not isinstance(override, str):
            raise ExperimentError(f"overrides[{place}]: got {shortened(override)}, {expected}")
    return found


def parse_override(override: str) -> tuple[list[str], Any]:
    """The key's parts and the value of ``"a.b=value"``."""
    key, equals, text = override.partition("=")
    parts = [part.strip().strip("\"'") for part in key.split(".")]
    if not equals or not all(parts):
        raise ExperimentError(f"override {shortened(override)}: expected key=value, such as component.grains=500")
    if len(parts) > _MOST_PARTS or max(map(len, parts)) > _LONGEST_PART:
        raise ExperimentError(
            f"override {shortened(override)}: a key of {len(parts)} parts, the longest of {max(map(len, parts))} characters; "
            f"expected at most {_MOST_PARTS} parts of {_LONGEST_PART}"
        )
    return parts, _value(override, text.strip())


def _value(override: str, text: str) -> Any:
    refuse_long_keys(f"override {shortened(override)}", text)
    try:
        parsed = tomllib.loads(f"value = {text}")
        if parsed.keys() == {"value"}:
            return parsed["value"]
    except (ValueError, RecursionError, ArithmeticError):
        if _BARE_WORD.fullmatch(text):
            return text
    raise ExperimentError(
        f"override {shortened(override)}: {shortened(text)} is no TOML value; write a number, a list, or a string in quotes"
    )


def _override(document: dict[str, Any], override: str) -> None:
    parts, value = parse_override(override)
    place = f"override {shortened(override)}"
    node: Any = document
    _refuse_key_without_table(parts, document, place)
    for depth, part in enumerate(parts):
        refuse_unknown(part, known_keys(".".join(parts[:depth]), document), place)
        last = depth == len(parts) - 1
        if isinstance(node, list):
            key: Any = _index(part, node, place)
        elif isinstance(node, dict):
            key = part
            if not last:
                node.setdefault(key, {})
        else:
            above = ".".join(parts[:depth])
            raise ExperimentError(f"{place}: {above} is {shortened(node)}, so it has no {part!r}; set {above} as a whole")
        if last:
            node[key] = value
        else:
            node = node[key]


def _refuse_key_without_table(parts: list[str], document: dict[str, Any], place: str) -> None:
    """`ExperimentError` for a key such as grains that belongs into a table: with the whole key."""
    if parts[0] in (known_keys("", document) or []):
        return
    for table in ("component", "record"):
        if parts[0] in (known_keys(table, document) or []):
            raise ExperimentError(f"{place}: {parts[0]!r} is unknown; did you mean {'.'.join([table, *parts])!r}?")


def _index(part: str, items: list[Any], place: str) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        raise ExperimentError(f"{place}: got the index {shortened(part)}, expected 0 to {len(items) - 1}")
    return int(part)
