"""The solitary wave of (2.4), by quadrature of the potential W(y) of `continuum`. Dimensionless.

Lengths are in diameters a, speeds in the sound speed c0 of the state ahead, strains in its strain xi_0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from ...errors import ParameterError
from ...support.float_arrays import FloatArray
from ...support.validation import whole_number
from .continuum import extreme_roots, ratio_from_c3

# Gauss points on each piece of a profile; for these smooth integrands eight points leave only rounding errors.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)
# A solitary wave is computed until its strain above xi_0 has fallen by the factor cosh^2 of this, to 2e-11 of its height.
_TAIL = 13.0


@dataclass(frozen=True, eq=False)
class StationaryWave:
    """A solitary wave u(x - Vt) of (2.4) as arrays; it travels towards larger x, with its crest at x = 0.

    Attributes:
        c3: constant C3 of the potential W.
        energy: energy of the particle in W, i.e. W(y1).
        position: x/a, increasing, not equidistant, shape (n,).
        y: y of (2.6), shape (n,).
        width: full width of the strain at half its height above the lowest strain, in a.
    """

    c3: float
    energy: float
    position: FloatArray
    y: FloatArray
    width: float

    @property
    def strain(self) -> FloatArray:
        """Strain xi in units of (V/c)^4, y^(4/5), shape (n,)."""
        return self.y**0.8

    @property
    def strain_ratio(self) -> FloatArray:
        """xi/xi_0, xi_0 the strain ahead of the wave, at the maximum y1 of W; shape (n,)."""
        return self.strain / extreme_roots(self.c3)[0] ** 2

    @property
    def amplitude_ratio(self) -> float:
        """Largest strain of the wave over the strain xi_0 ahead of it."""
        return float(self.strain_ratio.max())

    @property
    def speed_ratio(self) -> float:
        """V/c0 = sqrt(2/3) y1^(-1/5), c0 the sound speed at xi_0."""
        return (2.0 / (3.0 * extreme_roots(self.c3)[0])) ** 0.5


def solitary_wave(c3: float, samples: int = 401) -> StationaryWave:
    """Return the solitary wave, 0 < C3 < 5/27; its height over xi_0 is `ratio_from_c3`(C3).

    Args:
        c3: constant C3; `c3_from_ratio` returns it for a given height.
        samples: odd number of points of the profile, so that one is the crest.
    """
    if whole_number("samples", samples, 5) % 2 == 0:
        raise ParameterError(f"got {samples}", expected="an odd number, so that one point is the crest", at="samples")
    low, _ = extreme_roots(c3)
    energy = float(_potential_polynomial(c3)(low))
    high, rest = _solitary_factors(c3, low)
    depth = high - low

    # With s - s1 = depth sech^2(angle), the infinite time at the maximum of W becomes an infinite angle, and all is smooth.
    def root(angle: FloatArray) -> FloatArray:
        return low + depth / np.cosh(angle) ** 2

    def rate(angle: FloatArray) -> FloatArray:
        s = root(angle)
        return 5.0 * s**1.5 / np.sqrt(2.0 * depth * rest(s))

    angles = np.linspace(0.0, _TAIL, samples // 2 + 1)
    middle = (0.5 * (low**2 + high**2)) ** 0.5
    at_half = float(np.arccosh((depth / (middle - low)) ** 0.5))
    width = 2.0 * _antiderivative(rate, np.linspace(0.0, at_half, 33))[-1]
    # The half left of the crest is the mirror image of the right one; scale converts eta to diameters.
    eta, crest, scale = _antiderivative(rate, angles), root(angles), 10.0**-0.5
    position, y = np.concatenate((-eta[:0:-1], eta)) * scale, np.concatenate((crest[:0:-1], crest)) ** 2.5
    return StationaryWave(c3, energy, position, y, float(width) * scale)


def _potential_polynomial(c3: float) -> Polynomial:
    """Return the coefficients of W as a polynomial of s = y^(2/5)."""
    return Polynomial([0.0, 0.0, c3, 0.0, -0.625, 0.5])


def _solitary_factors(c3: float, low: float) -> tuple[float, Polynomial]:
    """Return the crest s_m, and the quadratic factor rest(s) of W(y1) - W(y) = (s - s1)^2 (s_m - s) rest(s)."""
    high = low * ratio_from_c3(c3) ** 0.5
    quotient = [-0.5, 0.625, 0.0, -c3, 0.0, float(_potential_polynomial(c3)(low))]
    for root in (low, low, high):
        quotient = _divide_by_root(quotient, root)
    return high, Polynomial((-np.array(quotient))[::-1])


def _divide_by_root(coefficients: list[float], root: float) -> list[float]:
    """Return a polynomial, highest power first, divided by s - root; the remainder is dropped."""
    quotient = [coefficients[0]]
    for coefficient in coefficients[1:-1]:
        quotient.append(coefficient + quotient[-1] * root)
    return quotient


def _antiderivative(rate: Callable[[FloatArray], FloatArray], nodes: FloatArray) -> FloatArray:
    """Return the integral of `rate` from the first node to each node, shape (nodes,)."""
    half = 0.5 * np.diff(nodes)
    places = nodes[:-1, None] + half[:, None] * (1.0 + _POINTS)
    return np.concatenate(([0.0], np.cumsum(half * (rate(places) @ _WEIGHTS))))
