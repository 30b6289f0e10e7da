"""Stationary waves of (2.4), solitary and shock-like, by quadrature of W(y). Dimensionless.

Lengths in diameters a, speeds in the sound speed c0 of the state in front, strains in its strain xi_0. Where there is no such
state (C3 = 0) use `strain`, which gives xi in units of (V/c)^4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from ...errors import ParameterError
from ...support.validation import whole_number
from .arguments import FloatArray, above, between, number
from .continuum import LARGEST_C3, extreme_roots, ratio_of_c3

# Gauss's points on each piece of a profile; the integrands are smooth, eight leave rounding only.
# Below this C3 the strain in front alone changes with it.
_SMALLEST_SHOCK_C3 = 1e-7
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)
# A solitary wave is followed until its strain above xi_0 has fallen by cosh^2 of this: 6e-11 of its height.
_TAIL = 13.0


@dataclass(frozen=True, eq=False)
class StationaryWave:
    """A wave u(x - Vt) of (2.4) as arrays; it travels towards larger x, its crest or front is at x = 0.

    Attributes:
        c3: C3 of W.
        energy: of the particle in W; W(y1) for a solitary wave.
        position: x/a, increasing, not equidistant, shape (n,).
        y: of (2.6), shape (n,).
        width: full width of the strain at half its height above the lowest strain, in a; NaN for a shock.
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
        """xi/xi_0, xi_0 the strain of the maximum y1 of W, shape (n,). Errors: `ParameterError` at C3 = 0, where it is 0."""
        return self.strain / self._rest() ** 2

    @property
    def amplitude_ratio(self) -> float:
        """The largest xi/xi_0."""
        return float(self.strain.max()) / self._rest() ** 2

    @property
    def speed_ratio(self) -> float:
        """V/c0 = sqrt(2/3) y1^(-1/5), c0 the sound speed at xi_0."""
        return (2.0 / (3.0 * self._rest())) ** 0.5

    def _rest(self) -> float:
        if not self.c3:
            raise ParameterError(
                "got 0, where there is no strain xi_0 to compare with", hint="use strain, in units of (V/c)^4", at="c3"
            )
        return extreme_roots(self.c3)[0]


def solitary_wave(c3: float, samples: int = 401) -> StationaryWave:
    """Return the solitary wave, 0 < C3 < 5/27; its height over xi_0 is `ratio_of_c3`(C3).

    Args:
        c3: `c3_of_ratio` gives it for a height.
        samples: points of the profile, odd, so that one is the crest.
    """
    c3 = number("c3", between("c3", c3, 0.0, LARGEST_C3))
    if whole_number("samples", samples, 5) % 2 == 0:
        raise ParameterError(f"got {samples}", expected="an odd number, so that one point is the crest", at="samples")
    low, _ = extreme_roots(c3)
    energy = float(_hill(c3)(low))
    high, rest = _solitary_factors(c3, low)
    depth = high - low

    # s - s1 = depth sech^2(angle): the particle's infinite time near the hilltop is an infinite angle, and all is smooth.
    def root(angle: FloatArray) -> FloatArray:
        return low + depth / np.cosh(angle) ** 2

    def rate(angle: FloatArray) -> FloatArray:
        s = root(angle)
        return 5.0 * s**1.5 / np.sqrt(2.0 * depth * rest(s))

    angles = np.linspace(0.0, _TAIL, samples // 2 + 1)
    middle = (0.5 * (low**2 + high**2)) ** 0.5
    at_half = float(np.arccosh((depth / (middle - low)) ** 0.5))
    width = 2.0 * _antiderivative(rate, np.linspace(0.0, at_half, 33))[-1]
    # Both halves from that right of the crest; eta in diameters.
    eta, crest, scale = _antiderivative(rate, angles), root(angles), 10.0**-0.5
    position, y = np.concatenate((-eta[:0:-1], eta)) * scale, np.concatenate((crest[:0:-1], crest)) ** 2.5
    return StationaryWave(c3, energy, position, y, float(width) * scale)


def shock_wave(c3: float, viscosity: float, length: float = 40.0, samples: int = 2001) -> StationaryWave:
    """Return a stationary shock in a chain with a linear dashpot g d(delta)/dt in each contact, 1e-7 <= C3 < 5/27 - 1e-9.

    The paper argues with weak losses and writes no equation for them. The dashpot adds (g a^2/m) xi_xxt to the long-wave
    equation of the strain, and -(4/5) mu y^(-2/5) y_t to the particle's motion in W, t = -eta, mu = sqrt(10) g a/(m V): it
    leaves the hilltop y1 and comes to rest in y2. Weak losses: the front is a solitary wave, and oscillations follow; from mu =
    5/2 s2 sqrt(2/5 (3 - 2/s2)) on, s2 = y2^(2/5), none.

    Args:
        c3: C3 of W; the strain behind over that in front is `shock_ratio`(C3).
        viscosity: 0 < mu < 500, dimensionless.
        length: how far behind the front the wave is followed, in a; to settle, weak losses need some 3/mu,
            strong ones some 10 mu.
        samples: points of the profile, equidistant; the front, where the mean strain of both sides is passed, is at x = 0.
    """
    from scipy.integrate import solve_ivp

    c3 = number("c3", between("c3", c3, _SMALLEST_SHOCK_C3, LARGEST_C3 - 1e-9, closed_below=True))
    viscosity = number("viscosity", between("viscosity", viscosity, 0.0, 500.0))
    length = number("length", above("length", length, 0.0))
    samples = whole_number("samples", samples, 16)
    rim, bottom = extreme_roots(c3)
    start, end = rim**2.5, bottom**2.5

    # In z = ln y, whose errors are relative ones: y1 may be so small that nothing else is exact at both ends.
    def motion(_: float, state: FloatArray) -> list[float]:
        fall, rate = np.exp(-0.4 * state[0]), state[1]
        return [rate, fall - 1.0 - 0.8 * c3 * fall**3 - 0.8 * viscosity * fall * rate - rate * rate]

    # Down the unstable direction of the hilltop: rate^2 + 2 p rate - curvature = 0.
    curvature, drag = 0.4 * (2.0 / rim - 3.0), 0.4 * viscosity / rim
    growth = curvature / ((drag**2 + curvature) ** 0.5 + drag)
    push = 1e-7
    climb = (np.log(1e7 * end / start) + 5.0) / growth + 20.0
    middle = np.log(0.5 * (rim**2 + bottom**2)) * 1.25
    # Strong friction is stiff.
    found: Any = solve_ivp(
        motion, (0.0, climb + length * 10.0**0.5), [np.log(start) + push, push * growth], method="LSODA", rtol=1e-10,
        atol=1e-12 * np.array([1.0, min(1.0, growth)]), dense_output=True, events=lambda _, state: state[0] - middle,
    )  # fmt: skip
    front = found.t_events[0][0]
    times = np.linspace(front + length * 10.0**0.5, 0.0, samples)
    y = np.maximum(np.exp(found.sol(times)[0]), start)
    return StationaryWave(c3, float(_hill(c3)(rim)), (front - times) / 10.0**0.5, y, np.nan)


def _hill(c3: float) -> Polynomial:
    """W as a polynomial of s = y^(2/5)."""
    return Polynomial([0.0, 0.0, c3, 0.0, -0.625, 0.5])


def _solitary_factors(c3: float, low: float) -> tuple[float, Polynomial]:
    """Return the crest s_m, and the quadratic that is left of W(y1) - W(y) = (s - s1)^2 (s_m - s) rest(s)."""
    high = low * ratio_of_c3(c3) ** 0.5
    quotient = [-0.5, 0.625, 0.0, -c3, 0.0, float(_hill(c3)(low))]
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
    """Integral of `rate` from the first node to each, shape (nodes,)."""
    half = 0.5 * np.diff(nodes)
    places = nodes[:-1, None] + half[:, None] * (1.0 + _POINTS)
    return np.concatenate(([0.0], np.cumsum(half * (rate(places) @ _WEIGHTS))))
