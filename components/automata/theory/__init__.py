"""Closed forms for movable cellular automata; no step calls them. SI units."""

from __future__ import annotations

from .dispersion import lattice_frequencies, leapfrog_frequency, rotation_frequency
from .restitution import restitution
from .speeds import longitudinal_speed, shear_speed
from .strength import (
    confined_strength,
    confining_pressure,
    drucker_prager_stress,
    equivalent_stress,
    fracture_toughness,
    platen_stress,
    splitting_tension,
    uniaxial_strength,
)

__all__ = [
    "confined_strength",
    "confining_pressure",
    "drucker_prager_stress",
    "equivalent_stress",
    "fracture_toughness",
    "lattice_frequencies",
    "leapfrog_frequency",
    "longitudinal_speed",
    "platen_stress",
    "restitution",
    "rotation_frequency",
    "shear_speed",
    "splitting_tension",
    "uniaxial_strength",
]
