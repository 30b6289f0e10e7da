"""Two spheres that meet: F = k d^1.5 between them, nothing lost. SI units.

The numbers in brackets are the equations of Nesterenko (1983). All formulas are exact for Hertz's static law.
"""

from __future__ import annotations

import math

import numpy as np

from .arguments import Number, above, number

# T1 (paper: 2.94) in units of (5 m* / 4 k)^(2/5) v^(-1/5): 2 sqrt(pi) Gamma(7/5) / Gamma(9/10).
COLLISION_COEFFICIENT = 2.943275184324706


def collision_duration(reduced_mass: Number, stiffness: Number, speed: Number) -> Number:
    """T1, the time two spheres touch when they meet at `speed`: 2.943 (5 m*/4k)^(2/5) v^(-1/5) [s].

    Between equal spheres m*/k = 1/(2A), and it is the paper's T1 = 2.94 (5/8A)^(2/5) / v0^(1/5) (section 3).

    Args:
        reduced_mass: 1/(1/m1 + 1/m2) [kg].
        stiffness: k of F = k d^1.5 [N/m^1.5].
        speed: relative speed at first touch [m/s].
    """
    reduced_mass, stiffness = _contact(reduced_mass, stiffness)
    return COLLISION_COEFFICIENT * (1.25 * reduced_mass / stiffness) ** 0.4 * above("speed", speed, 0.0, "m/s") ** -0.2


def collision_overlap(reduced_mass: Number, stiffness: Number, speed: Number) -> Number:
    """Largest overlap of two spheres that meet at `speed`: (5 m* v^2 / 4k)^(2/5) [m]."""
    reduced_mass, stiffness = _contact(reduced_mass, stiffness)
    return (1.25 * reduced_mass * above("speed", speed, 0.0, "m/s") ** 2 / stiffness) ** 0.4


def duration_of_overlap(reduced_mass: Number, stiffness: Number, overlap: Number) -> Number:
    """T1 of the collision whose largest overlap is `overlap`: both formulas above, the speed eliminated [s]."""
    reduced_mass, stiffness = _contact(reduced_mass, stiffness)
    # Not a power: a run's report comes from here, and has the same bits on every machine.
    root = np.sqrt(above("overlap", overlap, 0.0, "m"))
    return COLLISION_COEFFICIENT * np.sqrt(1.25 * reduced_mass / (stiffness * root))


def duration_times_frequency(growth: float) -> float:
    """Duration of a collision x its largest angular frequency, where F = k d^growth: 4.03 for spheres, pi for springs.

    With D the largest overlap, v^2 = 2 k D^(p + 1) / ((p + 1) m*), the duration is (2 D / v) sqrt(pi) Gamma(1 + 1/(p + 1)) /
    Gamma(1/2 + 1/(p + 1)) and the frequency sqrt(p k D^(p - 1) / m*).
    """
    growth = number("growth", above("growth", growth, 0.0, "1"))
    part = 1.0 / (growth + 1.0)
    duration = 2.0 * math.sqrt(math.pi) * math.gamma(1.0 + part) / math.gamma(0.5 + part)
    return duration * math.sqrt(0.5 * growth * (growth + 1.0))


def _contact(reduced_mass: Number, stiffness: Number) -> tuple[Number, Number]:
    return above("reduced_mass", reduced_mass, 0.0, "kg"), above("stiffness", stiffness, 0.0, "N/m^1.5")
