"""Limits of memory, so that what does not fit is refused before it is tried."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import GranularError, ParameterError

_MEMINFO = Path("/proc/meminfo")
# More bytes than this are told as so many: whole numbers may be larger than any float.
_COUNTLESS = 10**300
_CONTAINER_LIMIT = Path("/sys/fs/cgroup/memory.max")


def available() -> int | None:
    """Bytes that a program may still take without driving others out; None where the system does not say.

    On Linux what the kernel estimates, and never more than a container may have; elsewhere all the memory of the machine.
    """
    amounts = [amount for amount in (_meminfo(), _container_limit()) if amount is not None]
    return min(amounts) if amounts else whole_memory()


def refuse_beyond(needed: int, what: str, kind: type[GranularError] = ParameterError) -> None:
    """Raise an error of that `kind`, with both numbers, where `needed` bytes are more than there are."""
    there = available()
    if there is not None and needed > there:
        raise kind(
            f"{what} needs at least {min(needed, _COUNTLESS) / 1e9:.3g} GB of memory, {there / 1e9:.3g} GB are available; "
            "ask for less, or use a machine with more"
        ) from MemoryError()


def _meminfo() -> int | None:
    try:
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    except (OSError, ValueError, IndexError):
        pass
    return None


def _container_limit() -> int | None:
    try:
        return int(_CONTAINER_LIMIT.read_text())
    except (OSError, ValueError):  # no container, or "max": no limit
        return None


def whole_memory() -> int | None:
    """Return the bytes of memory of this machine; None where the system does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None
