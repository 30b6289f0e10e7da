"""Movable cellular automata: Psakhie et al. (2003)."""

from __future__ import annotations

from .component import Automata
from .parameters import AutomataParameters

__all__ = ["Automata", "AutomataParameters"]
