"""A solid with thin walls, meshfree and in three dimensions: Gato & Shie (2010)."""

from __future__ import annotations

from .component import Shell
from .parameters import ShellParameters

__all__ = ["Shell", "ShellParameters"]
