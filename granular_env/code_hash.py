"""A hash of the code that determines results, by which sweeps and studies recognise results stored by other code."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

from granular_env.components.support.jit import kernel_source_hash

# `kernel_source_hash` hashes the components. The command line and the pictures are left out: they do not affect results.
_ELSEWHERE = ("components", "cli", "viewing")


@cache
def code_hash() -> str:
    """Hash the code of this package and of plug-ins, and the versions of numerical packages."""
    state = hashlib.sha256(f"{kernel_source_hash()} {version('scipy')} {version('pydantic')}".encode())
    root = Path(__file__).resolve().parent
    for path in sorted(root.rglob("*.py")):
        if path.relative_to(root).parts[0] not in _ELSEWHERE:
            state.update(path.read_bytes())
    return state.hexdigest()[:16]
