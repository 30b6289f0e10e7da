"""Speeds of elastic waves whose length is much larger than an automaton."""

from __future__ import annotations

import math


def longitudinal_speed(density: float, shear: float, lame: float) -> float:
    """Return the speed of longitudinal waves, sqrt((lambda + 2 G) / rho) [m/s].

    Args:
        density: [kg/m^3].
        shear: G [Pa].
        lame: lambda [Pa].
    """
    return math.sqrt((lame + 2.0 * shear) / density)


def shear_speed(density: float, shear: float) -> float:
    """Return the speed of shear waves, sqrt(G / rho) [m/s].

    Args:
        density: [kg/m^3].
        shear: G [Pa].
    """
    return math.sqrt(shear / density)
