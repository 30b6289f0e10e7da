"""The Chapman-Jouguet detonation of a perfect gas: the slowest complete burn, with sonic flow behind it.

With M = D / c0 and H = (gamma^2 - 1) q / (2 c0^2): M = sqrt(1 + H) + sqrt(H).
Source: W. Fickett, W. C. Davis, Detonation (1979), section 2A.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .gases import Gas


class Flow(NamedTuple):
    """A state of the gas, in the frame of the tube.

    Attributes:
        density: mass density [kg/m^3].
        velocity: velocity along x [m/s].
        pressure: pressure [Pa].
    """

    density: float
    velocity: float
    pressure: float


class Detonation(NamedTuple):
    """A steady detonation into gas at rest.

    Attributes:
        speed: detonation speed D [m/s].
        mach: Mach number, D over the speed of sound ahead.
        burnt: the Chapman-Jouguet state, at the end of the reaction.
        shocked: the von Neumann point, behind the shock and before the reaction.
        sound_speed: speed of sound in the burnt state [m/s].
    """

    speed: float
    mach: float
    burnt: Flow
    shocked: Flow
    sound_speed: float


def chapman_jouguet(gas: Gas, pressure: float, density: float) -> Detonation:
    """Return the Chapman-Jouguet detonation into gas at rest; a sound wave if the gas releases no heat.

    Args:
        gas: the gas, with its heat release.
        pressure: initial pressure [Pa].
        density: initial density [kg/m^3].
    """
    gamma = gas.gamma
    sound = math.sqrt(gamma * pressure / density)
    h = 0.5 * (gamma * gamma - 1.0) * gas.heat_release / (sound * sound)
    mach = math.sqrt(1.0 + h) + math.sqrt(h)
    speed = mach * sound
    # On the Rayleigh line, the sonic point is halfway between the initial state and the shocked state.
    burnt = _state_behind_wave(gamma, mach, pressure, density, 1.0)
    shocked = _state_behind_wave(gamma, mach, pressure, density, 2.0)
    return Detonation(speed, mach, burnt, shocked, math.sqrt(gamma * burnt.pressure / burnt.density))


def _state_behind_wave(gamma: float, mach: float, pressure: float, density: float, branch: float) -> Flow:
    """Return a state on the Rayleigh line: `branch` is 1 at the sonic point and 2 at the shocked state."""
    square = mach * mach
    after = pressure * (1.0 + branch * gamma * (square - 1.0) / (gamma + 1.0))
    velocity = branch * (square - 1.0) / ((gamma + 1.0) * square) * mach * math.sqrt(gamma * pressure / density)
    return Flow(density / (1.0 - branch * (square - 1.0) / ((gamma + 1.0) * square)), velocity, after)
