"""The potential W(y) in which a stationary wave of (2.4) moves as a particle: extremes, heights, speeds. Dimensionless.

A stationary wave u(x - Vt) of (2.4) moves as a particle of unit mass in the potential W (Nesterenko 1983, section 2):

    y'' = -dW/dy,   W(y) = -5/8 y^(8/5) + 1/2 y^2 + C3 y^(4/5),   strain xi = (V/c)^4 y^(4/5),   x = a eta / sqrt 10

with C3 = (5/4) C2 of (2.6), whose scale of length is printed wrong. For 0 < C3 < 5/27 W has a maximum y1 < (2/3)^(5/2), the
state in front of a wave, and a minimum y2 > y1, the state behind a shock. With s = y^(2/5) both are
roots of s^2 - s^3 = 4 C3/5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .arguments import Number, above, at_least, between, finite, number

LARGEST_C3 = 5.0 / 27.0


class Extremes(NamedTuple):
    """The places of W's maximum y1 and of its minimum y2."""

    y1: float
    y2: float


def W(y: Number, c3: float) -> Number:
    """Return the potential, for y >= 0 and any C3 (the paper's fig. 1: C3 = 4/27 and 0.1)."""
    y, c3 = at_least("y", y, 0.0), finite("c3", c3)
    return -0.625 * y**1.6 + 0.5 * y**2 + c3 * y**0.8


def extremes(c3: float) -> Extremes:
    """y1 and y2 for 0 <= C3 < 5/27; at C3 = 0 they are 0 and 1."""
    low, high = extreme_roots(c3)
    return Extremes(low**2.5, high**2.5)


def extreme_roots(c3: float) -> tuple[float, float]:
    """s1 and s2, s = y^(2/5): the two positive roots of s^2 - s^3 = 4 C3/5."""
    c3 = number("c3", between("c3", c3, 0.0, LARGEST_C3, closed_below=True, advice="beyond 5/27 W has no extremes"))
    # With s = 1/3 + 2/3 cos(angle) the cubic is cos(3 angle) = 1 - 10.8 C3; with sines no digit is lost at C3 -> 0.
    third = 2.0 / 3.0 * float(np.arcsin(min(1.0, (5.4 * c3) ** 0.5)))
    low = 2.0 * np.sin(0.5 * third) ** 2 + 3.0**0.5 * np.sin(third)
    return float(low) / 3.0, float(1.0 + 2.0 * np.cos(third)) / 3.0


def c3_of_ratio(ratio: Number) -> Number:
    """C3 of the solitary wave whose largest strain is r = xi_m/xi_0 > 1 times that at rest."""
    root = _first_root(ratio)
    return 1.25 * root**2 * (1.0 - root)


def ratio_of_c3(c3: float) -> float:
    """Return the ratio r = xi_m/xi_0 of the solitary wave with this C3, 0 < C3 < 5/27; the other way round is `c3_of_ratio`."""
    c3 = number("c3", between("c3", c3, 0.0, LARGEST_C3))
    root = extreme_roots(c3)[0]
    # From W(y_m) = W(y1), sigma = sqrt r = s_m/s1: s1 (2 sigma^3 + 4 sigma^2 + 6 sigma + 3) = 5/2 (sigma + 1)^2.
    found = np.roots([2.0 * root, 4.0 * root - 2.5, 6.0 * root - 5.0, 3.0 * root - 2.5])
    return float(found.real[np.abs(found.imag) < 1e-9].max()) ** 2


def speed_ratio(ratio: Number) -> Number:
    """V/c0 of the solitary wave of height r = xi_m/xi_0 > 1: sqrt((4/15)(3 + 2 r^2.5 - 5 r))/(r - 1).

    The closed form of the quadrature of W. It is slower than the wave of the chain itself (`lattice_wave`) by
    0.04 % at r = 1.563, 0.6 % at 7.93, 1.2 % at 186.
    """
    # With sigma = sqrt r the factor (sigma - 1)^2 cancels, and with it the loss of digits near r = 1.
    sigma = above("ratio", ratio, 1.0) ** 0.5
    return (4.0 / 15.0 * (2.0 * sigma**3 + 4.0 * sigma**2 + 6.0 * sigma + 3.0)) ** 0.5 / (sigma + 1.0)


def ratio_of_speed(speed: float) -> float:
    """Return the ratio r = xi_m/xi_0 of the solitary wave that travels at `speed` V/c0 > 1, the inverse of `speed_ratio`."""
    square = 3.75 * number("speed", above("speed", speed, 1.0)) ** 2
    found = np.roots([2.0, 4.0 - square, 6.0 - 2.0 * square, 3.0 - square])
    return float(found.real[np.abs(found.imag) < 1e-9].max()) ** 2


def shock_ratio(c3: float) -> float:
    """xi_c/xi_0, the strain far behind a stationary shock over that in front, (s2/s1)^2; 0 < C3 < 5/27."""
    low, high = extreme_roots(between("c3", c3, 0.0, LARGEST_C3))
    return (high / low) ** 2


def shock_speed_ratio(ratio: Number) -> Number:
    """D/c0 of a shock from xi_0 to xi_c = ratio xi_0, from mass and momentum: sqrt(2/3 (r^1.5 - 1)/(r - 1))."""
    sigma = above("ratio", ratio, 1.0) ** 0.5
    return (2.0 / 3.0 * (sigma**2 + sigma + 1.0) / (sigma + 1.0)) ** 0.5


def _first_root(ratio: Number) -> Number:
    sigma = above("ratio", ratio, 1.0) ** 0.5
    return 2.5 * (sigma + 1.0) ** 2 / (2.0 * sigma**3 + 4.0 * sigma**2 + 6.0 * sigma + 3.0)
