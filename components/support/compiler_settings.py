"""Settings that hold while numba compiles: what costs time and changes no code is off."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import errors

_errors: Any = errors


class _PlainText:
    """Messages without the codes of terminals, in the form of numba's colour schemes.

    Numba looks for what does not exist thousands of times, and words an error each time.
    """

    def __getattr__(self, part: str) -> Any:
        """Return what marks a part of a message, which is nothing."""
        return _unchanged


def _unchanged(message: str) -> str:
    return message


@contextmanager
def quick_compilation() -> Iterator[None]:
    """Collect no garbage, a sixth of the time, and mark up no messages until the end of the block."""
    collected, scheme = gc.isenabled(), getattr(_errors, "_termcolor_inst", None)
    gc.disable()
    _errors._termcolor_inst = _PLAIN
    try:
        yield
    finally:
        _errors._termcolor_inst = scheme
        if collected:
            gc.enable()


_PLAIN = _PlainText()
