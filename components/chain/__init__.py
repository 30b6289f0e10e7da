"""Nesterenko's granular chain (1983)."""

from __future__ import annotations

from .component import Chain
from .parameters import ChainParameters, UniformRadii

__all__ = ["Chain", "ChainParameters", "UniformRadii"]
