"""The constant-volume burn named by Gato & Shie (2010), implemented literally: a negative result, kept for comparison.

Gas burns in proportion to its compression, and the law overwrites the pressure:

    Y' = 1 - (V - V0) / (V_CJ - V0), V = 1 / rho, between 0 and 1;
    Y' = 0 where Y < Y' and Y' < 0.9;  p = (1 - Y') P_CJ where Y' < 0.99;  Y = Y'.

Energy is not conserved; the energy balance shows the amount added by the overwriting. The front locks to a simple number of
cells per step h, such as 1/6, 2/7 or 1/2. It therefore runs 9 to 40 % faster than D, depending on D h / dx but not on the mesh;
near D h / dx = 0.6 it is not even steady. The gas at rest behind it has a pressure of 0.42 to 0.55 P_CJ instead of 0.368 P_CJ.
Use `pressure_burn`.
Source: C. L. Mader, Numerical Modeling of Detonations (1979), as used for thin-walled tubes.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...support.parameter_fields import field
from ..chapman_jouguet import Detonation
from ..gases import Gas
from .reaction import Reaction, ReactionResult, advance_reaction

_NOTHING = 1e-8


class ConstantVolumeConstants(NamedTuple):
    """Volume per mass V0 of fresh and V_CJ of burnt gas [m^3/kg], and pressure P_CJ of burnt gas [Pa]."""

    initial_volume: float
    burnt_volume: float
    burnt_pressure: float


class ConstantVolume(Reaction):
    """Pressure is overwritten while the gas is compressed; a documented negative result."""

    name: Literal["constant_volume"] = field("constant_volume", "overwrites the pressure (a negative result)", "1")

    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> ConstantVolumeConstants:
        """Return V0, V_CJ [m^3/kg] and P_CJ [Pa]."""
        return ConstantVolumeConstants(1.0 / ahead[1], 1.0 / front.burnt.density, front.burnt.pressure)

    def cautions(self, cell_size: float) -> list[str]:
        """Return the caution that this law is wrong."""
        return [
            "the reaction constant_volume overwrites pressures: its front is 9 to 40 % or more too fast on any mesh, depending "
            "on the step, and it does not conserve energy; take the reaction pressure_burn"
        ]


@advance_reaction.register(ConstantVolumeConstants)
def _advance_reaction(law, density, pressure, fraction, step):
    new = 1.0 - (1.0 / density - law.initial_volume) / (law.burnt_volume - law.initial_volume)
    burns = 0.0 <= new and new <= 1.0 and fraction > _NOTHING
    new = 0.0 if fraction < new and new < 0.9 else new
    written = (1.0 - new) * law.burnt_pressure if new < 0.99 else pressure
    return ReactionResult(new if burns else fraction, written if burns else pressure)
