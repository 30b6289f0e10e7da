"""A long tube of an elastic material under inner pressure, its length held.

Source: S. P. Timoshenko, J. N. Goodier, Theory of Elasticity (1951), 28; for the critical speed W. M. Beltman, J. E. Shepherd,
J. Sound Vib. 252 (2002) 617.
"""

from __future__ import annotations

import math


def breathing_frequency(young: float, poisson: float, density: float, radius: float) -> float:
    """Return the frequency [Hz] at which a thin tube of that mean radius breathes: plane strain along it."""
    return math.sqrt(young / (density * (1.0 - poisson * poisson))) / (2.0 * math.pi * radius)


def lame_displacement(young: float, poisson: float, inner: float, wall: float, pressure: float, radius: float) -> float:
    """Return the radial displacement [m] at a radius, of plane strain."""
    outer = inner + wall
    scale = pressure * inner * inner / (outer * outer - inner * inner)
    return (1.0 + poisson) / young * scale * ((1.0 - 2.0 * poisson) * radius + outer * outer / radius)


def static_hoop_stress(inner: float, wall: float, pressure: float) -> float:
    """Return the mean hoop stress [Pa] of a static pressure."""
    return pressure * inner / wall


def critical_speed(young: float, poisson: float, density: float, radius: float, wall: float) -> float:
    """Return the speed [m/s] at which a load that travels along a thin tube resonates with its flexural waves."""
    squared = young * wall / (density * radius) / math.sqrt(3.0 * (1.0 - poisson * poisson))
    return math.sqrt(squared)
