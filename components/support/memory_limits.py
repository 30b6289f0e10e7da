"""Memory limits, so that oversized requests are refused before they are tried."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import GranularError, ParameterError

_MEMINFO = Path("/proc/meminfo")
# Upper limit of sizes in messages [bytes], because integers may exceed any float.
_COUNTLESS = 10**300
_CONTAINER_LIMIT = Path("/sys/fs/cgroup/memory.max")


def available_memory() -> int | None:
    """Return the memory available to a program without displacing others, in bytes; None if the system does not report it.

    On Linux this is the kernel's estimate, at most the limit of the container; on other systems the memory of the machine.
    """
    amounts = [amount for amount in (_meminfo(), _container_limit()) if amount is not None]
    return min(amounts) if amounts else total_memory()


def refuse_excess_memory(needed: int, subject: str, error_type: type[GranularError] = ParameterError) -> None:
    """Raise an error of type `error_type`, with the needed and the available memory, if less is available than needed."""
    there = available_memory()
    if there is not None and needed > there:
        raise error_type(
            f"{subject} needs at least {min(needed, _COUNTLESS) / 1e9:.3g} GB of memory, but {there / 1e9:.3g} GB are "
            "available; reduce the size, or use a machine with more memory"
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


def total_memory() -> int | None:
    """Return the memory of this machine in bytes; None if the system does not report it."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None
