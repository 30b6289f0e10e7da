"""The refresh of numba's registries, after imports alone: numba would read them again for each array that is used."""

from __future__ import annotations

import sys
from typing import Any

_modules_read = 0


def refresh_after_imports(context: Any) -> None:
    """Let a target read what was registered, unless no module was imported since the last time."""
    global _modules_read
    if len(sys.modules) != _modules_read:
        type(context).refresh(context)
        _modules_read = len(sys.modules)
