"""A detonation in a tube a part of which gives way: Gato & Shie (2010)."""

from __future__ import annotations

from .component import Tube
from .parameters import TubeParameters

COMPILATION = ("the exchange of gas and solid", 4)

__all__ = ["Tube", "TubeParameters"]
