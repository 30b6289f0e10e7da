"""Notices of the compiler: what is compiled, for how long, where it is kept.

A package whose kernels take seconds to compile declares ``COMPILATION = ("the chain", 8)``: their name, and the seconds of one
core that all of them take, about.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from numba.core import event

from ..notice import tell
from .cache_folder import cache_folder

_announced: set[str] = set()
_locks: list[int] = []  # open files; a lock is held as long as its file is open

# The name of what is compiled and its seconds, in the package that the kernels live in, or in one above it.
_DECLARATION = "COMPILATION"


class _Listener(event.Listener):
    """Says what is compiled when numba begins to; what that calls is compiled within, and is part of it."""

    def __init__(self) -> None:
        self._depth = 0

    def on_start(self, event: Any) -> None:
        """Numba begins to compile a function."""
        self._depth += 1
        if self._depth == 1:
            _tell_of(str(event.data["dispatcher"].py_func.__module__))

    def on_end(self, event: Any) -> None:
        """Numba has compiled it, or has failed."""
        self._depth -= 1


def listen() -> None:
    """Tell of every compilation from now on."""
    event.register("numba:compile", _Listener())


def _tell_of(module: str) -> None:
    name, seconds = _declaration(module)
    if not name or name in _announced:
        return
    _announced.add(name)
    folder = cache_folder()
    if folder is None or _is_first(folder, name):
        kept = "in every process, because they cannot be kept" if folder is None else f"once; kept in {folder}"
        tell(f"compiling the kernels of {name} for this computer: about {seconds} s of one core, {kept}")


def _declaration(module: str) -> tuple[str, int]:
    """Return what the nearest package around a module says of its kernels: their name, and the seconds that they take."""
    while module:
        found = getattr(sys.modules.get(module), _DECLARATION, None)
        if found is not None:
            return found
        module = module.rpartition(".")[0]
    return "", 0


def _is_first(folder: Path, name: str) -> bool:
    """Return whether no other process that is still there has said it: of many workers one speaks."""
    try:
        import fcntl

        file = os.open(folder / f".{name.replace(' ', '-')}.notice", os.O_WRONLY | os.O_CREAT, 0o600)
        _locks.append(file)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ImportError:
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True
