"""The CSV files that an experiment names: their content goes with the tasks, wherever they run."""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from granular_env.documents.files import read_data


def names_a_file(key: str, value: Any) -> bool:
    """Return whether a key of the experiment holds the path of a CSV file."""
    return isinstance(value, str) and key.startswith("input.") and key.endswith(".path")


def gather_files(
    document: Mapping[str, Any], folder: Path, assigned: Iterable[tuple[str, Any]]
) -> tuple[dict[str, Any], dict[str, str], dict[str, bytes]]:
    """Return an experiment whose CSV files are named by their content.

    Args:
        document: the experiment's content.
        folder: what its paths are relative to.
        assigned: keys and values that tasks set; some may be paths.

    Returns:
        The experiment with those names; path -> name; name -> content.

    Raises:
        ExperimentError: a file cannot be read.
    """
    changed = copy.deepcopy(dict(document))
    names: dict[str, str] = {}
    contents: dict[str, bytes] = {}

    def name_by_content(path: str) -> str:
        if path not in names:
            data = read_data(folder / path)
            names[path] = f"{hashlib.sha256(data).hexdigest()[:32]}.csv"
            contents[names[path]] = data
        return names[path]

    for table in _csv_tables(changed.get("input", {})):
        table["path"] = name_by_content(table["path"])
    for key, value in assigned:
        if names_a_file(key, value):
            name_by_content(value)
    return changed, names, contents


def write_files(contents: Mapping[str, bytes], folder: Path) -> None:
    """Put them where the tasks look for them."""
    if contents:
        folder.mkdir(parents=True, exist_ok=True)
    for name, data in contents.items():
        (folder / name).write_bytes(data)


def _csv_tables(node: Any) -> Iterator[dict[str, Any]]:
    if isinstance(node, dict):
        if node.get("profile") == "csv":
            yield node
        for part in node.values():
            yield from _csv_tables(part)
    elif isinstance(node, list):
        for part in node:
            yield from _csv_tables(part)
