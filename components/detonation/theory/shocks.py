"""Plane shocks of a perfect gas: the Rankine-Hugoniot relations.

Source: H. W. Liepmann, A. Roshko, Elements of Gasdynamics (1957), sections 2.13 and 3.9.
"""

from __future__ import annotations

import math

from ..chapman_jouguet import Flow


def state_behind_shock(ahead: Flow, gamma: float, mach: float) -> Flow:
    """Return the state behind a shock that runs to the right at Mach number `mach` relative to the gas ahead."""
    density, velocity, pressure = ahead
    square = mach * mach
    sound = math.sqrt(gamma * pressure / density)
    compression = (gamma + 1.0) * square / ((gamma - 1.0) * square + 2.0)
    after = pressure * (1.0 + 2.0 * gamma / (gamma + 1.0) * (square - 1.0))
    return Flow(density * compression, velocity + sound * mach * (1.0 - 1.0 / compression), after)


def reflected_pressure(incoming: Flow, gamma: float) -> float:
    """Return the pressure [Pa] on a rigid wall that stops a gas flow of velocity `incoming.velocity`.

    The positive root of (P - p)^2 = rho u^2 ((gamma + 1) P + (gamma - 1) p) / 2.
    """
    density, velocity, pressure = incoming
    a = 0.25 * (gamma + 1.0) * density * velocity * velocity
    return pressure + a + math.sqrt(a * a + gamma * pressure * density * velocity * velocity)
