"""Notices on stderr, each once in a process. ``GRANULAR_ENV_QUIET=1`` hides them."""

from __future__ import annotations

import os
import sys

_said: set[str] = set()


def tell(message: str) -> None:
    """Write one line to stderr, once in a process; nothing where ``GRANULAR_ENV_QUIET`` is set to anything but 0."""
    if message in _said or os.environ.get("GRANULAR_ENV_QUIET", "0") not in ("", "0"):
        return
    _said.add(message)
    if sys.stderr is not None:
        print(f"granular-env: {message}", file=sys.stderr, flush=True)
