"""Comparison of numba's flags by one text: numba compares them one by one, at each look-up of an operation's type."""

from __future__ import annotations

from typing import Any

from numba.core.compiler import Flags


class QuickFlags(Flags):
    """Flags that one text tells, which is made where they are first looked up: they change no more then."""

    __slots__ = ("_text",)

    def __hash__(self) -> int:
        """Return the hash of the text."""
        return hash(self._content())

    def __eq__(self, other: Any) -> bool:
        """Return whether the same flags are set to the same values."""
        return self is other or (isinstance(other, QuickFlags) and self._content() == other._content())

    def _content(self) -> str:
        try:
            return self._text
        except AttributeError:
            self._text = self.summary()
            return self._text
