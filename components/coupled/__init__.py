"""A grid and movable cellular automata that share an interface: Psakhie et al. (2003)."""

from __future__ import annotations

from .component import Coupled
from .parameters import CoupledParameters

__all__ = ["Coupled", "CoupledParameters"]
