"""Notices of the compiler on stderr: what is compiled, for how long, where it is kept. ``GRANULAR_ENV_QUIET=1`` hides them."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from numba.core import event

_said: set[str] = set()
_locks: list[Any] = []  # open files; a lock is held as long as its file is open

# Where a function lives, what it belongs to, and the seconds of one core that all of them take, about.
_GROUPS = (
    ("granular_env.components.chain.adjoint", "gradients", 10),
    ("granular_env.components", "the chain", 8),
    ("granular_env", "environments", 10),
)


def tell(message: str) -> None:
    """Write one line to stderr, once in a process; nothing where ``GRANULAR_ENV_QUIET`` is set to anything but 0."""
    if message in _said or os.environ.get("GRANULAR_ENV_QUIET", "0") not in ("", "0"):
        return
    _said.add(message)
    if sys.stderr is not None:
        print(f"granular-env: {message}", file=sys.stderr, flush=True)


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
    from .kernel_cache import cache_folder

    group = next((group for group in _GROUPS if f"{module}.".startswith(f"{group[0]}.")), None)
    if group is None or group[1] in _said:
        return
    _, name, seconds = group
    _said.add(name)
    folder = cache_folder()
    if folder is None or _is_first(folder, name):
        kept = "in every process, because they cannot be kept" if folder is None else f"once; kept in {folder}"
        tell(f"compiling the kernels of {name} for this computer: about {seconds} s of one core, {kept}")


def _is_first(folder: Path, name: str) -> bool:
    """Return whether no other process that is still there has said it: of many workers one speaks."""
    try:
        import fcntl

        file = (folder / f".{name.replace(' ', '-')}.told").open("a")
        _locks.append(file)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ImportError:
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True
