"""One-step reaction with an Arrhenius rate: Gato & Shie (2010).

    dY/dt = -k Y exp(-E rho / p), where Y is the unreacted fraction.

In a step the exponential is constant: Y falls exactly by exp(-k dt exp(-E rho / p)). k follows from the half-reaction length,
the distance behind the shock of the steady wave at which half the gas has reacted. The mesh must resolve it: with 5, 10, 20
cells and the default activation, the speed of the steady wave is right within 0.7, 0.2, 0.1 %, its peak within 5, 3, 2 %.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from ...support.elementary_functions import exponential
from ...support.parameter_fields import Magnitude, field
from ...support.powers import power
from ..chapman_jouguet import Detonation
from ..gases import Gas
from .reaction import Reaction, ReactionResult, advance_reaction

_ONE_OVER_E = 0.36787944117144233
# The rate is zero above this exponent, to limit the argument of `power`.
_LARGEST_EXPONENT = 100.0
_INTERVALS = 400
# Number of cells in the half-reaction length below which the law issues a caution.
_LEAST_CELLS = 10.0


class ArrheniusConstants(NamedTuple):
    """The rate k [1/s] and the activation energy E [J/kg]."""

    rate: float
    energy: float


class Arrhenius(Reaction):
    """A rate that grows with p / rho, so that the heat of the shock starts the reaction."""

    name: Literal["arrhenius"] = field("arrhenius", "one-step reaction of the rate k Y exp(-E rho / p)", "1")
    activation: Magnitude = field(2.5, "activation energy E, divided by p / rho behind the leading shock", "1", le=40.0)
    half_reaction_length: Magnitude = field(
        5e-3, "distance behind the shock of the steady wave at which half of the gas has reacted", "m"
    )

    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> ArrheniusConstants:
        """Return the rate k [1/s] and the activation energy E [J/kg]."""
        energy = self.activation * front.shocked.pressure / front.shocked.density
        return ArrheniusConstants(half_reaction_integral(gas, front, ahead, energy) / self.half_reaction_length, energy)

    def ignition_pressure(self, front: Detonation, ahead: tuple[float, float]) -> float:
        """Return the pressure at which gas of the initial density has the temperature behind the leading shock [Pa]."""
        return ahead[1] * front.shocked.pressure / front.shocked.density

    def cautions(self, cell_size: float) -> list[str]:
        """Return a caution if the cells do not resolve the reaction zone."""
        cells = self.half_reaction_length / cell_size
        if cells >= _LEAST_CELLS:
            return []
        return [
            f"the half-reaction length of {self.half_reaction_length:g} m spans {cells:.2g} cells, expected at least "
            f"{_LEAST_CELLS:g}; take more cells, or the reaction pressure_burn, which needs no resolved reaction zone"
        ]


def half_reaction_integral(gas: Gas, front: Detonation, ahead: tuple[float, float], energy: float) -> float:
    """Return the half-reaction length of the steady wave times k [m/s]: the integral of (D - u) exp(E rho / p) / Y over Y.

    By Simpson's rule over s = 1 - sqrt(Y), in arithmetic that is bitwise identical on every machine.
    """
    pressure, density = ahead
    square = front.mach * front.mach
    slowing = (square - 1.0) / ((gas.gamma + 1.0) * square)
    step = (1.0 - math.sqrt(0.5)) / _INTERVALS
    total = 0.0
    for place in range(_INTERVALS + 1):
        root = 1.0 - place * step
        part = 1.0 - (1.0 + root) * slowing
        here = pressure * (1.0 + (1.0 + root) * slowing * gas.gamma * square)
        value = 2.0 * part * front.speed / root * float(exponential(energy * density / (part * here)))
        total += value * (1.0 if place in (0, _INTERVALS) else 4.0 if place % 2 else 2.0)
    return total * step / 3.0


@advance_reaction.register(ArrheniusConstants)
def _advance_reaction(law, density, pressure, fraction, step):
    exponent = law.energy * density / pressure
    rate = law.rate * power(_ONE_OVER_E, exponent) if exponent < _LARGEST_EXPONENT else 0.0
    decay = step * rate
    left = fraction * power(_ONE_OVER_E, decay) if decay < _LARGEST_EXPONENT else 0.0
    return ReactionResult(left, pressure)
