"""A detonation in a tube, of which one section can yield and break: Gato & Shie (2010)."""

from __future__ import annotations

from .component import Tube
from .parameters import TubeParameters

__all__ = ["Tube", "TubeParameters"]
