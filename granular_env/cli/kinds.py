"""The kinds of TOML files (experiments, plans of sweeps, studies), and for each kind the command that runs it."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import NamedTuple

from granular_env.components.errors import ExperimentError


class Kind(NamedTuple):
    """A kind of TOML file that `command` runs; each has at least one of the top-level `keys`; `words` name it in messages."""

    words: str
    command: str
    keys: tuple[str, ...]


KINDS = {
    "experiments": Kind("an experiment", "run", ("component",)),
    "plans of sweeps": Kind("a sweep's plan", "sweep", ("experiment", "measure")),
    "studies": Kind("a study", "study", ("method", "task")),
}
"""Kind of document, named as in `package_contents.shipped_files` -> its name in messages, command and keys."""


def document_kind(name: str) -> str:
    """Return the kind of the TOML file `name`, found from its keys, or of the shipped item `name`; "" for anything else."""
    from granular_env.documents import read_toml
    from granular_env.package_contents import shipped_files

    if Path(name).suffix == ".toml" and Path(name).is_file():
        content = read_toml(Path(name))
        return next((kind for kind, known in KINDS.items() if any(key in content for key in known.keys)), "")
    return "" if Path(name).is_file() else next((kind for kind in KINDS if name in shipped_files(kind)), "")


def refuse_other_kinds(name: str, command: str) -> None:
    """Raise `ExperimentError` if the document `name` is run by another command than `command`; the error names that command."""
    found = KINDS.get(document_kind(name))
    if found is not None and found.command != command:
        hint = f"run it with: granular-env {found.command} {shlex.quote(name)}"
        raise ExperimentError(f"it is {found.words}", hint=hint, source=name)
