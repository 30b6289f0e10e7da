"""Von Mises plasticity with linear isotropic hardening, by radial return.

q = sqrt(3/2 s:s) <= Y + H e, where e is the equivalent plastic strain and q the equivalent stress. A trial stress outside is
scaled back along its deviator, e' = (q - Y - H e) / (3 mu + H); the pressure does not change. In plane strain with H = 0 this
is exact if the direction of the strain is constant.
Source: M. L. Wilkins, Methods in Computational Physics 3 (1964) 211.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .plastic_law import PlasticLaw, ReturnedStress, return_stress, yield_limit


class VonMisesConstants(NamedTuple):
    """Yield stress Y [Pa] and hardening H [Pa]."""

    yield_stress: float
    hardening: float


class VonMises(PlasticLaw):
    """Yield at an equivalent stress of yield_stress + hardening x equivalent plastic strain."""

    name: Literal["von_mises"] = field("von_mises", "metals: yield does not depend on pressure", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at first yield", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "increase of the yield stress with equivalent plastic strain", "Pa")

    def constants(self) -> VonMisesConstants:
        """Return Y and H."""
        return VonMisesConstants(self.yield_stress, self.hardening)


@yield_limit.register(VonMisesConstants)
def _yield_limit(law, plastic_strain, pressure):
    return law.yield_stress + law.hardening * plastic_strain


@return_stress.register(VonMisesConstants)
def _return_stress(law, moduli, plastic_strain, equivalent, pressure):
    beyond = equivalent - (law.yield_stress + law.hardening * plastic_strain)
    if beyond <= 0.0:
        return ReturnedStress(0.0, equivalent, pressure)
    strain = beyond / (3.0 * moduli.shear + law.hardening)
    return ReturnedStress(strain, equivalent - 3.0 * moduli.shear * strain, pressure)
