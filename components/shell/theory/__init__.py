"""Exact and classical solutions for thin walls: beams, bars, rings, tubes under pressure, pieces of a ring."""

from __future__ import annotations

from .beams import cantilever_frequency, cantilever_shape, clamped_bar_frequency
from .fragments import mott_fragments
from .travelling_load import front_amplification
from .tubes import breathing_frequency, critical_speed, lame_displacement, static_hoop_stress

__all__ = [
    "breathing_frequency",
    "cantilever_frequency",
    "cantilever_shape",
    "clamped_bar_frequency",
    "critical_speed",
    "front_amplification",
    "lame_displacement",
    "mott_fragments",
    "static_hoop_stress",
]
