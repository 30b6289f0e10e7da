"""Finding and reading studies: a shipped name, a file, or a dict; with single keys overridden."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from granular_env.components.errors import ExperimentError, nearest
from granular_env.experiments.faults import overridden, shortened
from granular_env.experiments.load import override_list, parse_override, read_document
from granular_env.shipped import shipped_files
from granular_env.toml_text import toml_value

from .methods import METHODS
from .schema import DriveTable, Study, parse

Source = str | os.PathLike[str] | Mapping[str, Any] | Study


def shipped_studies() -> list[str]:
    """Names of the studies that come with the package, such as ``pulse-forming``."""
    return list(shipped_files("studies"))


def load_study(source: Source, overrides: Iterable[str] = ()) -> Study:
    """A study, checked as far as that goes without building its environment.

    Args:
        source: a shipped study's name, the path of a TOML file, the content of one as a dict, or a study.
        overrides: ``"a.b=value"`` each, the value as in TOML: ``"budget=5000"``, ``"task.grains=30"``,
            ``"method.0.population=8"``.

    Raises:
        ExperimentError: file, table, key, what came and what was expected; unknown keys with the nearest right one.
    """
    overrides = override_list(overrides)
    if isinstance(source, Study):
        if not overrides:
            return source
        document, origin = source.to_dict(), source.origin
    elif isinstance(source, Mapping):
        document, origin = copy.deepcopy(dict(source)), "study"
    else:
        path = study_path(source)
        document, origin = read_document(path), str(path)
    for override in overrides:
        _override(document, override)
    with overridden(origin, overrides):
        return parse(document, origin)


def study_path(source: str | os.PathLike[str]) -> Path:
    """The file behind a shipped name or a path; `ExperimentError` where there is none."""
    try:
        path = Path(source)
        if path.is_file():
            return path
    except (TypeError, ValueError, OSError) as error:
        raise ExperimentError(f"study {shortened(source)}: no name and no path: {error}") from None
    if str(source) in shipped_studies():
        return shipped_files("studies")[str(source)]
    if path.exists():
        what = "a folder" if path.is_dir() else "a device, a pipe or a socket"
        raise ExperimentError(f"{path}: it is {what}, expected a TOML file or a name of `granular-env study --list`")
    if path.suffix == ".toml":
        raise ExperimentError(f"{path}: there is no such file")
    advice = nearest(str(source), shipped_studies())
    raise ExperimentError(f"study {shortened(str(source))}: no shipped study and no file; {advice}")


def is_study(document: Mapping[str, Any]) -> bool:
    """Whether the content of a TOML file is meant as a study: it compares methods, or names a task and no component."""
    return "component" not in document and ("method" in document or "task" in document)


def _override(document: dict[str, Any], override: str) -> None:
    parts, value = parse_override(override)
    place, node = f"override {shortened(override)}", document
    for depth, part in enumerate(parts):
        above = ".".join(parts[:depth])
        if isinstance(node, list):
            if not part.isdecimal() or int(part) >= len(node):
                raise ExperimentError(f"{place}: got the index {shortened(part)}, expected 0 to {len(node) - 1}")
            key: Any = int(part)
        elif isinstance(node, dict):
            key = part
            if (known := _known_keys(above, node)) is not None and key not in known:
                raise ExperimentError(f"{place}: {key!r} is unknown; {nearest(key, known)}")
        else:
            raise ExperimentError(f"{place}: {above} is {shortened(node)}, so it has no {part!r}; set {above} as a whole")
        if depth == len(parts) - 1:
            node[key] = value
        else:
            node = node.setdefault(key, {}) if isinstance(node, dict) else node[key]


def _known_keys(above: str, node: Mapping[str, Any]) -> list[str] | None:
    """The keys that a table of the file may have; None where any name may come (an environment's arguments)."""
    if above == "":
        return list(Study.model_fields)
    if above == "drive":
        return list(DriveTable.model_fields)
    if above.startswith("method.") and above.count(".") == 1 and node.get("type") in METHODS:
        return list(METHODS[str(node["type"])].model_fields)
    return None


def as_toml(study: Study) -> str:
    """A study as the text of a file that gives it again."""
    content = study.to_dict()
    lines = [f"{key} = {toml_value(value)}" for key, value in content.items() if key not in ("task", "drive", "method")]
    tables = [(f"[{key}]", content[key]) for key in ("task", "drive") if key in content]
    for head, table in [*tables, *(("[[method]]", method) for method in content["method"])]:
        lines += ["", head, *(f"{key} = {toml_value(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"
