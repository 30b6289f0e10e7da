"""Settings that hold while our kernels are compiled: what costs time and changes no code is off."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from numba.core import errors, event
from numba.core.compiler_lock import global_compiler_lock

from .variable_lists import quick_lists


class _NoColours:
    """What numba asks for the colours of its messages."""

    @staticmethod
    def code(message: str) -> str:
        """Return the message."""
        return message

    errmsg = filename = indicate = highlight = reset = code


@contextmanager
def quick_compilation() -> Iterator[None]:
    """Keep numba from what our kernels do not need until the end of the block; other threads compile before it or after it.

    Garbage is not collected, a sixth of the time; the errors that numba words and drops, one for each overload that does not
    fit, have no colours; and nobody counts the time that each call of LLVM takes.
    """
    with (
        global_compiler_lock, quick_lists(), _replaced(errors, "_termcolor_inst", _NoColours),
        _replaced(event, "install_timer", _no_timer),
    ):  # fmt: skip
        collected = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if collected:
                gc.enable()


def _no_timer(kind: str, callback: Any) -> Any:
    return nullcontext()


@contextmanager
def _replaced(module: Any, name: str, value: Any) -> Iterator[None]:
    before = getattr(module, name, None)
    setattr(module, name, value)
    try:
        yield
    finally:
        setattr(module, name, before)
