"""Text for a terminal: strangers' words made harmless."""

from __future__ import annotations


def printable(text: object) -> str:
    """Return a text whose control characters are written as escapes, so that no terminal obeys them.

    Names out of files may hold escape sequences, changes of the writing direction, or bytes that are no text.
    """
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in str(text))
