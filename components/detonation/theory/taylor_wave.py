"""The wave behind a Chapman-Jouguet front that starts at a closed end: G. I. Taylor (1950), Ya. B. Zeldovich.

Behind the front at x = D t the gas expands, c = ((gamma - 1) x / t + 2 c3) / (gamma + 1), until it is at rest at x = c3 t:
c3 = (gamma + 1) c_CJ / 2 - (gamma - 1) D / 2. The wave depends on x / t alone.
Source: G. I. Taylor, Proc. R. Soc. A 200 (1950) 235.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from ...support.float_arrays import FloatArray
from ..chapman_jouguet import Detonation, Flow


@dataclass(frozen=True)
class TaylorWave:
    """The gas from the closed end at x = 0 to the front and beyond.

    Attributes:
        front: the detonation.
        ahead: gas at rest ahead of the front.
        gamma: adiabatic exponent.
    """

    front: Detonation
    ahead: Flow
    gamma: float

    @property
    def resting_sound_speed(self) -> float:
        """Speed of sound c3 of the gas at rest behind the wave [m/s]."""
        return 0.5 * (self.gamma + 1.0) * self.front.sound_speed - 0.5 * (self.gamma - 1.0) * self.front.speed

    @property
    def plateau(self) -> float:
        """Pressure of the gas at rest behind the wave [Pa]."""
        ratio = self.resting_sound_speed / self.front.sound_speed
        return self.front.burnt.pressure * ratio ** (2.0 * self.gamma / (self.gamma - 1.0))

    def state(self, x: FloatArray, time: float | FloatArray) -> FloatArray:
        """Return density, velocity and pressure at positions [m] and times [s] after the start, shape (3, n)."""
        gamma, rest, sonic = self.gamma, self.resting_sound_speed, self.front.sound_speed
        ratio = np.asarray(x) / np.asarray(time)
        inside = np.clip(ratio, rest, self.front.speed)
        sound = ((gamma - 1.0) * inside + 2.0 * rest) / (gamma + 1.0)
        burnt = self.front.burnt
        wave = np.stack([
            burnt.density * (sound / sonic) ** (2.0 / (gamma - 1.0)),
            2.0 * (inside - rest) / (gamma + 1.0),
            burnt.pressure * (sound / sonic) ** (2.0 * gamma / (gamma - 1.0)),
        ])  # fmt: skip
        return np.where(ratio > self.front.speed, np.stack([np.full(ratio.shape, value) for value in self.ahead]), wave)

    def decay_time(self, x: float) -> float:
        """Return the decay time of the pressure at a position, about x / 3 D [s].

        P3 + (P2 - P3) exp(-(t - x / D) / T) with this T best fits p(t) from the front (P2) until the gas is at rest (P3).
        """
        front, rest = x / self.front.speed, x / self.resting_sound_speed
        times = np.linspace(front, rest, 2001)[1:]
        excess = (self.state(np.full(len(times), x), times)[2] - self.plateau) / (self.front.burnt.pressure - self.plateau)
        return fit_decay(times - front, excess)


def fit_decay(times: FloatArray, excess: FloatArray) -> float:
    """Return the T for which exp(-t / T) best fits `excess` at equidistant times, in the least-squares sense [s]."""

    def squared_error(logarithm: float) -> float:
        return float(((np.exp(-times / np.exp(logarithm)) - excess) ** 2).sum())

    bounds = (np.log(1e-3 * times[-1]), np.log(10.0 * times[-1]))
    found: Any = minimize_scalar(squared_error, bounds=bounds, options={"xatol": 1e-9})
    return float(np.exp(found.x))
