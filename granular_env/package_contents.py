"""The package's contents (components, experiments, plans, studies), found without importing the code that runs them."""

from __future__ import annotations

import re
from itertools import takewhile
from pathlib import Path

from granular_env.components import catalogue

_ROOT = Path(__file__).resolve().parent
_FOLDERS = {"experiments": "experiments", "plans of sweeps": "sweep/plans", "studies": "control/studies"}


def shipped_files(kind: str) -> dict[str, Path]:
    """Return the files of all shipped items of a kind (experiments, plans of sweeps or studies) by name, sorted."""
    folder = _ROOT / _FOLDERS[kind]
    found = {path.relative_to(folder).as_posix().removesuffix(".toml"): path for path in folder.rglob("*.toml")}
    return dict(sorted(found.items()))


def shipped_names() -> list[str]:
    """Return the names of all shipped items."""
    return [*catalogue.component_names(), *(name for kind in _FOLDERS for name in shipped_files(kind))]


def shipped_overview() -> dict[str, dict[str, str]]:
    """Return the one-line descriptions of all shipped items, by kind and name."""
    found = {"components": {name: catalogue.component_summary(name) for name in catalogue.component_names()}}
    return found | {kind: {name: _file_title(path) for name, path in shipped_files(kind).items()} for kind in _FOLDERS}


def _file_title(path: Path) -> str:
    """Return the one-line description of a TOML file: the first sentence of its initial comment or of its `description`."""
    import tomllib

    text = path.read_text(encoding="utf-8")
    comment = [line.removeprefix("#") for line in takewhile(lambda line: line.startswith("#"), text.splitlines())]
    return first_sentence(" ".join(comment) if comment else tomllib.loads(text)["description"])


def first_sentence(text: str) -> str:
    """Return the first sentence of a text: up to a full stop with a capital letter after it, so not up to "et al. (2003)"."""
    paragraph = " ".join(text.strip().partition("\n\n")[0].split())
    return re.split(r"\. (?=[A-Z`])", paragraph, maxsplit=1)[0].rstrip(".") + "."
