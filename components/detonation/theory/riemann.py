"""The exact Riemann problem of a perfect gas: two uniform states that meet at x = 0 and t = 0.

Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), chapter 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...support.float_arrays import FloatArray
from ..chapman_jouguet import Flow


@dataclass(frozen=True)
class RiemannSolution:
    """Two waves, shocks or rarefactions, and a contact between them.

    Attributes:
        left: the state at x < 0.
        right: the state at x > 0.
        gamma: adiabatic exponent.
        pressure: pressure between the two waves [Pa].
        velocity: velocity between the two waves, i.e. of the contact [m/s].
    """

    left: Flow
    right: Flow
    gamma: float
    pressure: float
    velocity: float

    def state(self, ratio: FloatArray) -> FloatArray:
        """Return density, velocity and pressure at x / t [m/s], shape (3, n)."""
        values = np.asarray(ratio, dtype=np.float64)
        left = _left_state(self.left, self.gamma, self.pressure, self.velocity, values)
        # The right side is the mirror image of a left one.
        mirrored = _left_state(
            self.right._replace(velocity=-self.right.velocity), self.gamma, self.pressure, -self.velocity, -values
        )
        mirrored[1] *= -1.0
        return np.where(values < self.velocity, left, mirrored)


def riemann_problem(left: Flow, right: Flow, gamma: float) -> RiemannSolution:
    """Return the `RiemannSolution` for two uniform states that meet at x = 0.

    Raises:
        ValueError: the states separate so fast that a vacuum opens.
    """
    speeds = [math.sqrt(gamma * one.pressure / one.density) for one in (left, right)]
    parting = right.velocity - left.velocity
    if parting >= 2.0 * sum(speeds) / (gamma - 1.0):
        raise ValueError(f"the states separate at {parting:g} m/s: a vacuum opens between them")

    def excess_velocity(pressure: float) -> float:
        return _velocity_change(left, gamma, pressure) + _velocity_change(right, gamma, pressure) + parting

    high = max(left.pressure, right.pressure)
    while excess_velocity(high) < 0.0:
        high *= 2.0
    pressure: Any = brentq(excess_velocity, 0.0, high, xtol=1e-15 * high, rtol=np.float64(1e-14))
    change = [_velocity_change(one, gamma, pressure) for one in (left, right)]
    velocity = 0.5 * (left.velocity + right.velocity) + 0.5 * (change[1] - change[0])
    return RiemannSolution(left, right, gamma, pressure, velocity)


def _velocity_change(state: Flow, gamma: float, pressure: float) -> float:
    """Return the velocity that gas loses through a wave from `state` to this pressure; negative in a rarefaction [m/s]."""
    density, _, ahead = state
    if pressure > ahead:
        return (pressure - ahead) * math.sqrt(2.0 / density / ((gamma + 1.0) * pressure + (gamma - 1.0) * ahead))
    sound = math.sqrt(gamma * ahead / density)
    return 2.0 * sound / (gamma - 1.0) * ((pressure / ahead) ** ((gamma - 1.0) / (2.0 * gamma)) - 1.0)


def _left_state(state: Flow, gamma: float, pressure: float, velocity: float, ratio: FloatArray) -> FloatArray:
    """Return the states to the left of the contact at x / t, shape (3, n)."""
    density, speed, ahead = state
    sound = math.sqrt(gamma * ahead / density)
    outer = np.stack([np.full(ratio.shape, value) for value in state])
    if pressure > ahead:
        strength = pressure / ahead
        front = speed - sound * math.sqrt((gamma + 1.0) / (2.0 * gamma) * strength + (gamma - 1.0) / (2.0 * gamma))
        k = (gamma - 1.0) / (gamma + 1.0)
        inner = np.stack(
            [np.full(ratio.shape, one) for one in (density * (strength + k) / (k * strength + 1.0), velocity, pressure)]
        )
        return np.where(ratio < front, outer, inner)
    behind = sound * (pressure / ahead) ** ((gamma - 1.0) / (2.0 * gamma))
    inner_density = density * (pressure / ahead) ** (1.0 / gamma)
    inner = np.stack([np.full(ratio.shape, one) for one in (inner_density, velocity, pressure)])
    inside = np.clip(ratio, speed - sound, velocity - behind)
    local = 2.0 / (gamma + 1.0) * (sound + 0.5 * (gamma - 1.0) * (speed - inside))
    fan = np.stack([
        density * (local / sound) ** (2.0 / (gamma - 1.0)),
        inside + local,
        ahead * (local / sound) ** (2.0 * gamma / (gamma - 1.0)),
    ])  # fmt: skip
    return np.where(ratio < speed - sound, outer, np.where(ratio > velocity - behind, inner, fan))
