"""A pulse as one collision after another, each between two grains alone: exact with gaps between the grains. SI units.

In a touching chain the pulse is five grains wide, and the law is the limit of small tapers: the settled ratio of successive
peaks is off by -0.03 % at q = 0.02, -0.35 % at 0.05, -2.5 % at 0.1, -0.05 % at -0.05 (growing grains), in runs of the chain.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...support.validation import whole_number
from .arguments import FloatArray, Number, above, between, finite, number, sequence


def transmitted_velocity(striker: Number, struck: Number, velocity: Number = 1.0) -> Number:
    """Return the velocity of a grain at rest, struck by another without loss: 2 v m1/(m1 + m2) [m/s]."""
    striker, struck = above("striker", striker, 0.0, "kg"), above("struck", struck, 0.0, "kg")
    return 2.0 * striker / (striker + struck) * finite("velocity", velocity)


def binary_velocities(mass: Any, velocity: float = 1.0) -> FloatArray:
    """With which each grain strikes the next, when the first one has `velocity`: prod 2 m_i/(m_i + m_(i+1)).

    Args:
        mass: of the grains, shape (n,) [kg].
        velocity: of the first grain [m/s].

    Returns:
        Shape (n,) [m/s]; the first is `velocity`.
    """
    mass = above("mass", sequence("mass", mass, 1), 0.0, "kg")
    ratios = 2.0 * mass[:-1] / (mass[:-1] + mass[1:])
    return number("velocity", velocity) * np.concatenate(([1.0], np.cumprod(ratios)))


def tapered_ratio(taper: Number) -> Number:
    """v_(i+1)/v_i in a chain whose radii fall by the factor 1 - q: 2/(1 + (1 - q)^3), -1 < q < 1; q < 0 grows."""
    return 2.0 / (1.0 + (1.0 - between("taper", taper, -1.0, 1.0)) ** 3)


def tapered_velocities(taper: float, grains: int) -> FloatArray:
    """Return each grain's velocity in units of the first, (2/(1 + (1 - q)^3))^i, shape (grains,)."""
    return tapered_ratio(number("taper", taper)) ** np.arange(whole_number("grains", grains, 1), dtype=np.float64)
