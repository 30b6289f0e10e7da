"""The units that make chains alike: of time, of speed, and the sound of a pressed chain. SI units.

A = k/m [1/(m^0.5 s^2)] of equal grains, a = 2R their diameter. The paper's c^2 = 2E/(pi rho (1 - nu^2)) is A a^(5/2).
"""

from __future__ import annotations

import math

from .arguments import Number, above, between


def time_scale(mass: Number, stiffness: Number, speed: Number) -> Number:
    """Return the unit of dimensionless time in (3.1), (A^2 v0)^(-1/5) with A = k/m [s]."""
    mass, stiffness = above("mass", mass, 0.0, "kg"), above("stiffness", stiffness, 0.0, "N/m^1.5")
    return ((stiffness / mass) ** 2 * above("speed", speed, 0.0, "m/s")) ** -0.2


def contact_constant(young: Number, poisson: float, density: Number, radius: Number) -> Number:
    """Return A = k/m of equal spheres, (2.1): E sqrt(2R) / (3 (1 - nu^2) m) [1/(m^0.5 s^2)].

    Args:
        young: E [Pa].
        poisson: nu, -1 to 0.5.
        density: [kg/m^3].
        radius: R [m].
    """
    diameter = 2.0 * above("radius", radius, 0.0, "m")
    return paper_speed(young, poisson, density) ** 2 / diameter**2.5


def paper_speed(young: Number, poisson: float, density: Number) -> Number:
    """Return the paper's c of (2.4), sqrt(2E / (pi rho (1 - nu^2))) [m/s]; no sound travels at it."""
    between("poisson", poisson, -1.0, 0.5 + 1e-12)
    young, density = above("young", young, 0.0, "Pa"), above("density", density, 0.0, "kg/m^3")
    return (2.0 * young / (math.pi * density * (1.0 - poisson**2))) ** 0.5


def paper_speed_scale(young: Number, poisson: float, density: Number, speed: Number) -> Number:
    """c^(4/5) v^(1/5), the unit of the paper's V and D1 (section 3.4) [m/s]: D1 is 1 of it, V 0.907470 of it."""
    return paper_speed(young, poisson, density) ** 0.8 * above("speed", speed, 0.0, "m/s") ** 0.2


def contact_speed(constant: Number, diameter: Number) -> Number:
    """Return the paper's c of (2.4) from A: sqrt(A a^(5/2)) [m/s]."""
    constant, diameter = above("constant", constant, 0.0, "1/(m^0.5 s^2)"), above("diameter", diameter, 0.0, "m")
    return constant**0.5 * diameter**1.25


def sound_speed(constant: Number, diameter: Number, overlap: Number) -> Number:
    """c0 of (2.3), of long waves in a chain pressed to `overlap` delta0: a sqrt(3/2 A delta0^(1/2)) [m/s].

    With a = 2R it is the paper's c0^2 = 6 A R^2 delta0^(1/2). It vanishes with delta0: an uncompressed chain has no sound.
    """
    constant, diameter = above("constant", constant, 0.0, "1/(m^0.5 s^2)"), above("diameter", diameter, 0.0, "m")
    return diameter * (1.5 * constant) ** 0.5 * above("overlap", overlap, 0.0, "m") ** 0.25
