"""A line load on the surface of an elastic half-space (Lamb's problem), by the method of Cagniard and de Hoop.

The force per length F(t) points along the depth z and acts on the line x = z = 0. With the slownesses a = 1 / c_p, b = 1 / c_s
of P and S, eta_c = sqrt(c^2 - p^2), g = b^2 - 2 p^2, Rayleigh's function R = g^2 + 4 p^2 eta_a eta_b, the impulse response is

    P:  u_z = Im[eta_a g / R dp/dt] / (pi mu),         u_x = Im[p g / R dp/dt] / (pi mu),
    S:  u_z = Im[2 p^2 eta_a / R dp/dt] / (pi mu),     u_x = Im[-2 p eta_a eta_b / R dp/dt] / (pi mu)

along p = c (sin v cosh s + i cos v sinh s), t = c r cosh s, c = a or b; v is the angle from the depth axis, r the distance. If
sin v > a / b, a head wave arrives before S: p = b sin f, f from asin(a / b) to v, t = b r cos(v - f). The root of R, i.e. the
Rayleigh wave, need not be computed: it lies near the path of S. Valid below the surface, z > 0.
Source: A. T. de Hoop, Appl. Sci. Res. B 8 (1960) 349; J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...materials.elastic import Material
from ...support.float_arrays import FloatArray

# Quadrature points along each path.
_POINTS = 4000


@dataclass(frozen=True)
class LineLoad:
    """A vertical line load on the free surface of a half-space.

    Attributes:
        material: of the half-space.
        force: load per length as a function of time, positive into the depth, 0 before 0; takes arrays [N/m].
        duration: of the load [s].
    """

    material: Material
    force: Callable[[FloatArray], FloatArray]
    duration: float

    def displacement(self, x: float, depth: float, times: FloatArray) -> FloatArray:
        """Return the displacements along x and depth at a point below the surface, shape (times, 2) [m].

        Args:
            x: distance along the surface, of either sign [m].
            depth: below the surface, more than 0 [m].
            times: shape (k,) [s].
        """
        found = np.zeros((len(times), 2))
        for part in (self._body_wave(abs(x), depth, times, shear=False), self._body_wave(abs(x), depth, times, shear=True)):
            found += part
        found += self._head_wave(abs(x), depth, times)
        found[:, 0] *= math.copysign(1.0, x) if x != 0.0 else 0.0
        return found / (math.pi * self.material.shear_modulus)

    def arrivals(self, x: float, depth: float) -> dict[str, float]:
        """Return the first arrival times of P, S and, if there is one, the head wave at a point [s]."""
        a, b = self._slownesses
        r, angle = math.hypot(x, depth), math.atan2(abs(x), depth)
        critical = math.asin(a / b)
        head = {"head": b * r * math.cos(angle - critical)} if angle > critical else {}
        return {"P": a * r, **head, "S": b * r}

    @property
    def _slownesses(self) -> tuple[float, float]:
        return 1.0 / self.material.longitudinal_speed, 1.0 / self.material.shear_speed

    def _body_wave(self, x: float, depth: float, times: FloatArray, *, shear: bool) -> FloatArray:
        """Return the integral over s of the impulse response times the force at t - c r cosh s, shape (times, 2)."""
        r, angle = math.hypot(x, depth), math.atan2(x, depth)
        c = self._slownesses[shear]
        latest = float(np.max(times, initial=0.0))
        if latest <= c * r:
            return np.zeros((len(times), 2))
        s = math.acosh(latest / (c * r)) * (np.arange(_POINTS) + 0.5) / _POINTS
        p = c * (math.sin(angle) * np.cosh(s) + 1j * math.cos(angle) * np.sinh(s))
        slope = c * (math.sin(angle) * np.sinh(s) + 1j * math.cos(angle) * np.cosh(s))
        return self._convolve(self._displacement_factors(p, shear) * slope, c * r * np.cosh(s), s[1] - s[0], times)

    def _head_wave(self, x: float, depth: float, times: FloatArray) -> FloatArray:
        a, b = self._slownesses
        r, angle, critical = math.hypot(x, depth), math.atan2(x, depth), math.asin(a / b)
        if angle <= critical:
            return np.zeros((len(times), 2))
        # The response grows as the root of f - asin(a / b), so the points are the squares of a uniform grid.
        part = (np.arange(_POINTS) + 0.5) / _POINTS
        f = critical + (angle - critical) * part * part
        weight = 2.0 * (angle - critical) * part / _POINTS
        # On the side above the real axis, eta_a = -i sqrt(p^2 - a^2).
        p = b * np.sin(f) + 0j
        values = self._displacement_factors(p, True, head=True) * (b * np.cos(f) * weight)
        return self._convolve(values, b * r * np.cos(angle - f), 1.0, times)

    def _displacement_factors(self, p: Any, shear: bool, *, head: bool = False) -> Any:
        """Return the factors of dp in u_x and u_z at slownesses p, shape (2, points); see the equations above."""
        a, b = self._slownesses
        eta_a = -1j * np.sqrt((p * p).real - a * a) if head else np.sqrt(a * a - p * p)
        eta_b = np.sqrt(b * b - p * p)
        g = b * b - 2.0 * p * p
        rayleigh = g * g + 4.0 * p * p * eta_a * eta_b
        along, down = (-2.0 * p * eta_a * eta_b, 2.0 * p * p * eta_a) if shear else (p * g, eta_a * g)
        return np.stack([along, down]) / rayleigh

    def _convolve(self, values: Any, delays: FloatArray, spacing: float, times: FloatArray) -> FloatArray:
        """Return the sum over the quadrature points of Im(values) force(t - delay) spacing, shape (times, 2)."""
        found = np.zeros((len(times), 2))
        for row, time in enumerate(times):
            since = time - delays
            load = np.where((since > 0.0) & (since < self.duration), self.force(np.maximum(since, 0.0)), 0.0)
            found[row] = (values.imag * load).sum(axis=1) * spacing
        return found
