"""A reactive gas in a tube, in one dimension: Gato & Shie (2010)."""

from __future__ import annotations

from .component import DetonationTube
from .parameters import DetonationParameters

COMPILATION = ("the gas", 8)

__all__ = ["DetonationParameters", "DetonationTube"]
