"""The continuum (2.4): the potential W(y), heights and speeds of its waves, and waves without precompression.

Dimensionless: lengths in diameters a, speeds V and particle velocities v in the paper's c (`contact_speed`), so that strain xi,
stress xi^1.5 and v = V xi are pure numbers. The overshoots are for a front with weak losses.

A stationary wave u(x - Vt) of (2.4) moves as a particle of unit mass in the potential W (Nesterenko 1983, section 2):

    y'' = -dW/dy,   W(y) = -5/8 y^(8/5) + 1/2 y^2 + C3 y^(4/5),   strain xi = (V/c)^4 y^(4/5),   x = a eta / sqrt 10

with C3 = (5/4) C2 of (2.6), whose length scale is misprinted. For 0 < C3 < 5/27 W has a maximum y1 < (2/3)^(5/2), the state in
front of a wave, and a minimum y2 > y1, the state behind a shock. With s = y^(2/5) both are roots of s^2 - s^3 = 4 C3/5.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...errors import ParameterError
from .long_waves import Number, contact_speed

LARGEST_C3 = 5.0 / 27.0


class Extremes(NamedTuple):
    """Positions of the maximum y1 and the minimum y2 of the potential W."""

    y1: float
    y2: float


def W(y: Number, c3: float) -> Number:
    """Return the value of the potential W, for y >= 0 and any C3 (the paper's fig. 1: C3 = 4/27 and 0.1)."""
    return -0.625 * y**1.6 + 0.5 * y**2 + c3 * y**0.8


def extremes(c3: float) -> Extremes:
    """Return the y1 and y2 at which W has its maximum and its minimum, for 0 <= C3 < 5/27; for C3 = 0 they are 0 and 1."""
    low, high = extreme_roots(c3)
    return Extremes(low**2.5, high**2.5)


def extreme_roots(c3: float) -> tuple[float, float]:
    """Return s1 and s2, s = y^(2/5): the two positive roots of s^2 - s^3 = 4 C3/5."""
    if not 0.0 <= c3 < LARGEST_C3:
        raise ParameterError(f"got {c3:g}", expected="at least 0 and less than 5/27, else W has no extremes", at="c3")
    # With s = 1/3 + 2/3 cos(angle) the cubic is cos(3 angle) = 1 - 10.8 C3; with sines no digits are lost for C3 -> 0.
    third = 2.0 / 3.0 * float(np.arcsin(min(1.0, (5.4 * c3) ** 0.5)))
    low = 2.0 * np.sin(0.5 * third) ** 2 + 3.0**0.5 * np.sin(third)
    return float(low) / 3.0, float(1.0 + 2.0 * np.cos(third)) / 3.0


def c3_from_ratio(ratio: Number) -> Number:
    """Return the C3 of the solitary wave whose largest strain is r = xi_m/xi_0 > 1 times the strain at rest."""
    root = _maximum_root(ratio)
    return 1.25 * root**2 * (1.0 - root)


def ratio_from_c3(c3: float) -> float:
    """Return the ratio r = xi_m/xi_0 of the solitary wave with this C3, 0 < C3 < 5/27; the inverse of `c3_from_ratio`."""
    root = extreme_roots(c3)[0]
    # W(y_m) = W(y1) at the crest; with sigma = s_m/s1 = sqrt r: s1 (2 sigma^3 + 4 sigma^2 + 6 sigma + 3) = 5/2 (sigma + 1)^2.
    found = np.roots([2.0 * root, 4.0 * root - 2.5, 6.0 * root - 5.0, 3.0 * root - 2.5])
    return float(found.real[np.abs(found.imag) < 1e-9].max()) ** 2


def speed_ratio(ratio: Number) -> Number:
    """Return V/c0 of the solitary wave of height r = xi_m/xi_0 > 1: sqrt((4/15)(3 + 2 r^2.5 - 5 r))/(r - 1).

    This is the closed form of the quadrature of W. It is slower than the wave of the lattice (`lattice_wave`) by
    0.04 % at r = 1.563, 0.6 % at 7.93, 1.2 % at 186.
    """
    # With sigma = sqrt r the factor (sigma - 1)^2 cancels, and so does the loss of digits near r = 1.
    sigma = ratio**0.5
    return (4.0 / 15.0 * (2.0 * sigma**3 + 4.0 * sigma**2 + 6.0 * sigma + 3.0)) ** 0.5 / (sigma + 1.0)


def shock_ratio(c3: float) -> float:
    """Return xi_c/xi_0, the strain far behind a stationary shock over that in front, (s2/s1)^2; 0 < C3 < 5/27."""
    low, high = extreme_roots(c3)
    return (high / low) ** 2


def shock_speed_ratio(ratio: Number) -> Number:
    """Return D/c0 of a shock from xi_0 to xi_c = ratio xi_0, from mass and momentum: sqrt(2/3 (r^1.5 - 1)/(r - 1))."""
    sigma = ratio**0.5
    return (2.0 / 3.0 * (sigma**2 + sigma + 1.0) / (sigma + 1.0)) ** 0.5


def _maximum_root(ratio: Number) -> Number:
    sigma = ratio**0.5
    return 2.5 * (sigma + 1.0) ** 2 / (2.0 * sigma**3 + 4.0 * sigma**2 + 6.0 * sigma + 3.0)


# L = 5 pi a / sqrt 10, the distance of two zeros of (2.7), in diameters; the paper: about 5.
PERIOD = 5.0 * math.pi / math.sqrt(10.0)
# Full width of (2.7) at half its height, in diameters.
HALF_WIDTH = 10.0 / math.sqrt(10.0) * math.acos(0.5**0.25)
# Peak at a front with weak losses over the value behind it: strain, velocity 25/16, pressure 125/64 (paper: 1.56, 1.95).
STRAIN_OVERSHOOT = 1.5625
PRESSURE_OVERSHOOT = 1.953125
# V = (16/25)^(1/5) v_m^(1/5), the paper's 0.915; the chain itself: `SOLITARY_SPEED`.
CONTINUUM_SOLITARY_SPEED = 0.64**0.2


def largest_strain(speed: Number) -> Number:
    """Return xi_m of (2.7), (5 V^2 / 4 c^2)^2; the power 2 is misprinted in the paper."""
    return (1.25 * speed**2) ** 2


def strain_wave(position: Number, speed: float) -> Number:
    """Return the periodic wave (2.7), xi = (5 V^2/4c^2)^2 cos^4(sqrt(10) x/5a); its hump |x| < L/2 is the solitary wave.

    It touches xi = 0, where (2.4) does not hold, at x = (5a/sqrt 10)(pi/2 + pi n).
    """
    return largest_strain(speed) * np.cos(10.0**0.5 / 5.0 * position) ** 4


def solitary_strain(position: Number, speed: float) -> Number:
    """Return the one hump of (2.7) at x = 0, and 0 elsewhere."""
    return strain_wave(np.clip(position, -0.5 * PERIOD, 0.5 * PERIOD), speed)


def shock_strain(speed: Number) -> Number:
    """Return xi_c = V^4/c^4, the strain behind a stationary shock into an uncompressed chain."""
    return speed**4


def shock_speed(constant: Number, diameter: Number, piston: Number) -> Number:
    """Return the speed D1 of the shock ahead of a piston of velocity v0 (section 3.4): c^(4/5) v0^(1/5) [m/s]; SI units.

    From mass and momentum, v0 = D1 xi_c and xi_c = (D1/c)^4, independent of the size of the grains. It requires losses: without
    losses the front is a faster solitary wave.

    Args:
        constant: A = k/m [1/(m^0.5 s^2)].
        diameter: a [m].
        piston: v0 [m/s].
    """
    return contact_speed(constant, diameter) ** 0.8 * piston**0.2


def front_velocity_ratio(coefficient: float) -> float:
    """Return v_m1/v0 of a solitary wave of speed D1: coefficient^(-5) (paper, 0.915: 1.56; lattice, 0.907470: 1.625)."""
    return coefficient**-5
