"""The continuum (2.4) without precompression, C3 = 0: the cos^4 wave (2.7), and shocks that conservation laws allow.

Dimensionless: lengths in diameters a, speeds V and particle velocities v in the paper's c (`contact_speed`), so that strain xi,
stress xi^1.5 and v = V xi are pure numbers. The overshoots are those of a front with weak losses.
"""

from __future__ import annotations

import math

import numpy as np

from .arguments import Number, above, finite
from .scales import contact_speed

# L = 5 pi a / sqrt 10, the distance of two zeros of (2.7), in diameters; the paper: about 5.
PERIOD = 5.0 * math.pi / math.sqrt(10.0)
# Full width of (2.7) at half its height, in diameters.
HALF_WIDTH = 10.0 / math.sqrt(10.0) * math.acos(0.5**0.25)
# On a front of weak losses over what remains behind it: strain (and velocity) 25/16, pressure 125/64 (paper: 1.56, 1.95).
STRAIN_OVERSHOOT = 1.5625
PRESSURE_OVERSHOOT = 1.953125
# V = (16/25)^(1/5) v_m^(1/5), the paper's 0.915; the chain itself: `SOLITARY_SPEED`.
CONTINUUM_SOLITARY_SPEED = 0.64**0.2


def largest_strain(speed: Number) -> Number:
    """xi_m of (2.7): (5 V^2 / 4 c^2)^2, with the power 2 that its misprints hide."""
    return (1.25 * above("speed", speed, 0.0) ** 2) ** 2


def strain_wave(position: Number, speed: float) -> Number:
    """(2.7): xi = (5 V^2/4c^2)^2 cos^4(sqrt(10) x/5a), periodic; one hump, |x| < L/2, stands for the solitary wave.

    It touches xi = 0, where (2.4) does not hold, at x = (5a/sqrt 10)(pi/2 + pi n).
    """
    return largest_strain(speed) * np.cos(10.0**0.5 / 5.0 * finite("position", position)) ** 4


def solitary_strain(position: Number, speed: float) -> Number:
    """Return the one hump of (2.7) at x = 0, and 0 elsewhere."""
    return strain_wave(np.clip(finite("position", position), -0.5 * PERIOD, 0.5 * PERIOD), speed)


def shock_strain(speed: Number) -> Number:
    """xi_c = V^4/c^4, behind a stationary shock that runs into an uncompressed chain."""
    return above("speed", speed, 0.0) ** 4


def shock_speed(constant: Number, diameter: Number, piston: Number) -> Number:
    """D1 of section 3.4, the shock before a piston of velocity v0: c^(4/5) v0^(1/5) [m/s]; SI units.

    From mass and momentum, v0 = D1 xi_c and xi_c = (D1/c)^4; independent of the grains' size. It needs losses: without
    them the front is a solitary wave that outruns it by V/D1 (`front_ratio`).

    Args:
        constant: A = k/m [1/(m^0.5 s^2)].
        diameter: a [m].
        piston: v0 [m/s].
    """
    return contact_speed(constant, diameter) ** 0.8 * above("piston", piston, 0.0, "m/s") ** 0.2


def front_ratio(coefficient: float, velocity_ratio: float = 2.0) -> float:
    """V/D1 of a front v_m = `velocity_ratio` v0 high, where V = `coefficient` c^(4/5) v_m^(1/5) (paper: 0.915, 2: 1.05)."""
    return above("coefficient", coefficient, 0.0) * above("velocity_ratio", velocity_ratio, 0.0) ** 0.2


def front_velocity_ratio(coefficient: float) -> float:
    """v_m1/v0 of a solitary wave as fast as D1: coefficient^(-5) (paper, with 0.915: 1.56; the chain's 0.907470: 1.625)."""
    return above("coefficient", coefficient, 0.0) ** -5
