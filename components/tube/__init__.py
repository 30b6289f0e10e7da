"""A detonation in a tube a part of which gives way: Gato & Shie (2010)."""

from __future__ import annotations

from .component import Tube
from .parameters import TubeParameters

__all__ = ["Tube", "TubeParameters"]
