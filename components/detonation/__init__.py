"""A reactive gas in a tube, in one dimension: Gato & Shie (2010)."""

from __future__ import annotations

from .component import DetonationTube
from .parameters import DetonationParameters

__all__ = ["DetonationParameters", "DetonationTube"]
