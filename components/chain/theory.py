"""Closed forms for the chain; no step calls them. Numbers in brackets are Nesterenko's (1983) equations."""

from __future__ import annotations

import math

# Duration of the collision of two spheres (paper: 2.94) in units of (5 m* / 4 k)^(2/5) v^(-1/5):
# 2 sqrt(pi) Gamma(7/5) / Gamma(9/10).
COLLISION_COEFFICIENT = 2.94328
# Speed of the uncompressed discrete solitary wave in diameters and units of (k/m)^(2/5) v_m^(1/5), measured on the
# chain itself.
SOLITARY_SPEED = 0.907470


def collision_duration(reduced_mass: float, stiffness: float, speed: float) -> float:
    """T1, the time two spheres touch when they meet at `speed`: 2.943 (5 m*/4k)^(2/5) v^(-1/5) [s].

    Args:
        reduced_mass: 1/(1/m1 + 1/m2) [kg].
        stiffness: k of F = k d^1.5 [N/m^1.5].
        speed: relative speed at first touch [m/s].
    """
    return COLLISION_COEFFICIENT * (1.25 * reduced_mass / stiffness) ** 0.4 * speed**-0.2


def collision_overlap(reduced_mass: float, stiffness: float, speed: float) -> float:
    """Largest overlap of two spheres that meet at `speed`: (5 m* v^2 / 4k)^(2/5) [m]."""
    return (1.25 * reduced_mass * speed**2 / stiffness) ** 0.4


def duration_of_overlap(reduced_mass: float, stiffness: float, overlap: float) -> float:
    """T1 of the collision whose largest overlap is `overlap`: both formulas above, the speed eliminated [s]."""
    return COLLISION_COEFFICIENT * math.sqrt(1.25 * reduced_mass / (stiffness * math.sqrt(overlap)))


def time_scale(mass: float, stiffness: float, speed: float) -> float:
    """The unit of dimensionless time in (3.1), (A^2 v0)^(-1/5) with A = k/m [s]."""
    return ((stiffness / mass) ** 2 * speed) ** -0.2


def paper_speed_scale(young: float, poisson: float, density: float, speed: float) -> float:
    """(2E / ((1 - nu^2) pi rho))^(2/5) v^(1/5), the unit of the paper's V and D1 [m/s]."""
    return (2.0 * young / ((1.0 - poisson**2) * math.pi * density)) ** 0.4 * speed**0.2
