"""The steady reaction zone of Zeldovich, von Neumann and Doering: a shock followed by the reaction, in the frame of the wave.

At each progress the state lies on the Rayleigh line of the wave. For the Chapman-Jouguet wave

    p = p0 (1 + gamma (M^2 - 1) (1 + sqrt(1 - progress)) / (gamma + 1)),

and with the rate k (1 - progress) exp(-E rho / p) the distance from the shock is the integral of (D - u) / rate.
Source: W. Fickett, W. C. Davis, Detonation (1979), section 2C.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...support.float_arrays import FloatArray
from ..chapman_jouguet import Detonation, Flow, chapman_jouguet
from ..gases import Gas


@dataclass(frozen=True)
class ReactionZone:
    """The steady wave with the rate k (1 - progress) exp(-E rho / p).

    Attributes:
        gas: the gas, with its heat release.
        ahead: gas at rest ahead of the wave.
        rate: k [1/s].
        activation_energy: E [J/kg].
    """

    gas: Gas
    ahead: Flow
    rate: float
    activation_energy: float

    @property
    def front(self) -> Detonation:
        """The Chapman-Jouguet detonation of this gas into the state `ahead`."""
        return chapman_jouguet(self.gas, self.ahead.pressure, self.ahead.density)

    def state(self, progress: FloatArray) -> FloatArray:
        """Return density, velocity and pressure at given values of the progress, shape (3, n)."""
        front, gamma = self.front, self.gas.gamma
        square = front.mach**2
        way = 1.0 + np.sqrt(1.0 - np.asarray(progress))
        slowing = way * (square - 1.0) / ((gamma + 1.0) * square)
        pressure = self.ahead.pressure * (1.0 + way * gamma * (square - 1.0) / (gamma + 1.0))
        return np.stack([self.ahead.density / (1.0 - slowing), slowing * front.speed, pressure])

    def distance(self, progress: FloatArray) -> FloatArray:
        """Return the distances behind the shock at which the progress has given increasing values from 0 to less than 1 [m]."""
        values = np.concatenate([[0.0], np.asarray(progress, dtype=np.float64)])
        # Gauss-Legendre quadrature between neighbouring values, over s = 1 - sqrt(1 - progress), which is regular at the shock.
        nodes, weights = np.polynomial.legendre.leggauss(20)
        s = 1.0 - np.sqrt(1.0 - values)
        middle, half = 0.5 * (s[1:] + s[:-1]), 0.5 * (s[1:] - s[:-1])
        inner = middle[:, None] + half[:, None] * nodes
        left = 1.0 - inner
        density, velocity, pressure = self.state(1.0 - left * left)
        rate = self.rate * left * left * np.exp(-self.activation_energy * density / pressure)
        return np.cumsum(((self.front.speed - velocity) / rate * 2.0 * left) @ weights * half)

    @property
    def half_reaction_length(self) -> float:
        """Distance behind the shock at which half of the gas has reacted [m]."""
        return float(self.distance(np.linspace(0.0, 0.5, 21)[1:])[-1])
