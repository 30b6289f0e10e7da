"""The runs of an atlas that are done: the same program does not do them again in the same folder."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

import granular_env
from granular_env.components.support.jit import source_hash

FINISHED = ".finished"


class FinishedRuns:
    """Names of the logs in an atlas's folder that this program has finished; several processes may add to them at a time.

    Args:
        folder: the atlas's, which has the names in a hidden file.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / FINISHED

    def has(self, name: str) -> bool:
        """Return whether the same program, byte for byte, has finished the log of this name."""
        return _line(name) in self._lines()

    def add(self, name: str) -> None:
        """Add a log that is finished."""
        with suppress(OSError), self._path.open("a", encoding="utf-8") as file:
            file.write(f"{_line(name)}\n")

    def names(self) -> set[str]:
        """Return the names of all logs that any program has finished here."""
        found = {line.partition(" ")[2] for line in self._lines()}
        return {name for name in found if name.endswith(".mcap") and Path(name).name == name}

    def keep(self, names: Iterable[str]) -> None:
        """Forget all but these."""
        wanted = set(names)
        lines = [line for line in dict.fromkeys(self._lines()) if line.partition(" ")[2] in wanted]
        with suppress(OSError):
            self._path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")

    def _lines(self) -> Iterable[str]:
        try:
            return self._path.read_text("utf-8").splitlines()
        except (OSError, UnicodeDecodeError):
            return []


def _line(name: str) -> str:
    return f"{_program()} {name}"


@cache
def _program() -> str:
    """Return a hash of all code that a log depends on: this package, and what computes for it."""
    state = hashlib.sha256(f"{source_hash()} {platform.python_version()} {platform.machine()}".encode())
    root = Path(granular_env.__file__).resolve().parent
    for path in sorted(root.rglob("*.py")):
        state.update(str(path.relative_to(root)).encode())
        state.update(path.read_bytes())
    return state.hexdigest()[:16]
