"""Exact solutions for the grid: wave speeds and impedances here, dispersion of the mesh, the line load on a half-space.

Plane strain, isotropic, small strains. No step calls them.
"""

from __future__ import annotations

import math

from ...materials.elastic import Material
from .dashpots import dashpot_reflection, reflected_energy
from .line_load import LineLoad
from .mesh_dispersion import mesh_frequencies

__all__ = [
    "LineLoad", "dashpot_reflection", "mesh_frequencies", "rayleigh_speed", "reflected_energy", "reflection", "transmission",
]  # fmt: skip


def rayleigh_speed(material: Material) -> float:
    """Return the speed of Rayleigh waves [m/s]: (2 - x)^2 = 4 sqrt((1 - x)(1 - k x)), x = (c / c_s)^2, k = (c_s / c_p)^2.

    Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), equation (5.95).
    """
    k = (material.shear_speed / material.longitudinal_speed) ** 2
    low, high = 0.1, 1.0
    # The difference is negative below the root, x = 0 apart, and positive up to 1.
    for _ in range(200):
        middle = 0.5 * (low + high)
        difference = (2.0 - middle) ** 2 - 4.0 * math.sqrt((1.0 - middle) * (1.0 - k * middle))
        low, high = (middle, high) if difference < 0.0 else (low, middle)
    return math.sqrt(low) * material.shear_speed


def reflection(first: Material, second: Material) -> float:
    """Return the velocity of the reflected P wave over that of the one that comes at right angles from `first`.

    (Z1 - Z2) / (Z1 + Z2), Z = density x speed.
    """
    one, two = (material.density * material.longitudinal_speed for material in (first, second))
    return (one - two) / (one + two)


def transmission(first: Material, second: Material) -> float:
    """Return the velocity of the P wave in `second` over that of the one that comes at right angles from `first`."""
    return 1.0 + reflection(first, second)
