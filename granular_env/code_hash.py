"""A hash of the code that decides results, for results that are kept: of sweeps and of studies."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

from granular_env.components.support.jit import source_hash

# The components are in `source_hash`; the command line and the pictures decide nothing.
_ELSEWHERE = ("components", "cli", "viewing")


@cache
def code_hash() -> str:
    """Hash the code of this package and of plug-ins, and the versions of the packages that compute."""
    state = hashlib.sha256(f"{source_hash()} {version('scipy')} {version('pydantic')}".encode())
    root = Path(__file__).resolve().parent
    for path in sorted(root.rglob("*.py")):
        if path.relative_to(root).parts[0] not in _ELSEWHERE:
            state.update(path.read_bytes())
    return state.hexdigest()[:16]
