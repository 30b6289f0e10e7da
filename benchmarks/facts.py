"""Origin of the figures: CPU and package versions."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version
from pathlib import Path

PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "mcap")


def machine_facts() -> str:
    """Return a few lines on the machine, its load and the package versions."""
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    load = os.getloadavg()[0]
    return f"{cpu_model()}, {os.cpu_count()} cores, load {load:.1f}\nPython {platform.python_version()}, {packages}"


def cpu_model() -> str:
    """Return the CPU's model name and, if the operating system reports it, its widest vector extension."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    told = dict([part.strip() for part in line.split(":", 1)] for line in lines if ":" in line)
    flags = told.get("flags", "").split()
    widest = next((name for name in ("avx512f", "avx2", "avx") if name in flags), "")
    return " ".join(part for part in (told.get("model name", platform.machine()), widest) if part)
