"""Exact solutions for the grid: impedances here; Rayleigh waves, dispersion of the mesh, a line load on a half-space.

Plane strain, isotropic, small strains. No step calls them.
"""

from __future__ import annotations

from ...materials.elastic import Material
from .dashpots import dashpot_reflection, reflected_energy
from .fronts import Front, load_fronts
from .line_load import LineLoad
from .mesh_dispersion import mesh_frequencies
from .rayleigh import rayleigh_ellipse, rayleigh_speed

__all__ = [
    "Front", "LineLoad", "dashpot_reflection", "load_fronts", "mesh_frequencies", "rayleigh_ellipse", "rayleigh_speed",
    "reflected_energy", "reflection", "transmission",
]  # fmt: skip


def reflection(first: Material, second: Material) -> float:
    """Return the velocity of the reflected P wave over that of the one that comes at right angles from `first`.

    (Z1 - Z2) / (Z1 + Z2), Z = density x speed.
    """
    one, two = (material.density * material.longitudinal_speed for material in (first, second))
    return (one - two) / (one + two)


def transmission(first: Material, second: Material) -> float:
    """Return the velocity of the P wave in `second` over that of the one that comes at right angles from `first`."""
    return 1.0 + reflection(first, second)
