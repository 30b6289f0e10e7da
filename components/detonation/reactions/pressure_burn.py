"""Pressure-triggered burn: once p > trigger P_CJ, the gas burns completely while the front crosses `width` cells.

    dY/dt = -D / (width dx)    if p > trigger P_CJ and Y > 0, where Y is the unreacted fraction.

Energy is conserved: chemical energy becomes thermal energy. The reaction zone has a width of some cells and thus no physical
length; speed, Chapman-Jouguet state and the wave behind it do not depend on it. If trigger x width is small, gas burns before
its shock arrives: the front outruns the shock, which is a weak detonation.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...errors import ParameterError
from ...support.parameter_fields import field
from ..chapman_jouguet import Detonation
from ..gases import Gas
from .reaction import Reaction, ReactionResult, advance_reaction

# Measured at triggers of 0.1 to 0.3: if trigger x width is at least this, the speed is that of Chapman-Jouguet within 0.4 %.
_LEAST_PRODUCT = 0.3


class PressureBurnConstants(NamedTuple):
    """The pressure that starts the burn [Pa], and the rate of the burn [1/s]."""

    trigger: float
    rate: float


class PressureBurn(Reaction):
    """Gas burns over a few cells once the pressure passes a trigger."""

    name: Literal["pressure_burn"] = field("pressure_burn", "burn over a few cells, triggered by pressure", "1")
    trigger: float = field(
        0.2, "pressure that starts the burn, as a fraction of the Chapman-Jouguet pressure", "1", ge=0.05, le=0.5
    )
    width: float = field(2.0, "number of cells that the front crosses while the gas burns", "1", ge=1.0, le=20.0)

    def cautions(self, cell_size: float) -> list[str]:
        """Return a caution if the front may outrun its shock."""
        if self.trigger * self.width >= _LEAST_PRODUCT:
            return []
        return [
            f"pressure_burn with trigger x width = {self.trigger * self.width:.2g}: below {_LEAST_PRODUCT:g} gas burns before "
            "its shock arrives, in a weak detonation that is too fast; take a larger width"
        ]

    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> PressureBurnConstants:
        """Return the starting pressure [Pa] and the rate [1/s]; `ParameterError` if the gas ahead would burn at once."""
        if ahead[0] >= self.trigger * front.burnt.pressure:
            part = ahead[0] / front.burnt.pressure
            raise ParameterError(
                f"got {self.trigger:g} of the Chapman-Jouguet pressure, {front.burnt.pressure:.4g} Pa, but the gas at "
                f"rest already has {part:.4g} of it, so that all gas would burn at once",
                expected=f"more than {part:.4g}",
                hint="take a larger trigger, more gas.heat_release, or the reaction arrhenius",
                at=("reaction", "trigger"),
            )
        return PressureBurnConstants(self.trigger * front.burnt.pressure, front.speed / (self.width * cell_size))

    def ignition_pressure(self, front: Detonation, ahead: tuple[float, float]) -> float:
        """Return the pressure that starts the burn, trigger x P_CJ [Pa]."""
        return self.trigger * front.burnt.pressure


@advance_reaction.register(PressureBurnConstants)
def _advance_reaction(law, density, pressure, fraction, step):
    left = fraction - step * law.rate
    left = left if left > 0.0 else 0.0
    return ReactionResult(left if pressure > law.trigger else fraction, pressure)
