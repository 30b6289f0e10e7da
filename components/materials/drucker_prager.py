"""Drucker-Prager plasticity with a non-associated flow rule and linear hardening, by return to the cone or to its tip.

q <= Y + H e + a p: equivalent stress q, equivalent plastic strain e, pressure p (positive in compression), yield stress Y,
hardening H, friction a. The flow is dilatant: the plastic volume strain is b e, b the dilatancy. A trial stress outside the
yield surface returns by e' = (q - Y - H e - a p) / (3 mu + K a b + H), q -> q - 3 mu e', p -> p + K b e', and e grows by e'. A
stress beyond the tip of the cone returns to the tip p = -(Y + H e) / a; e grows by q / 3 mu and by the plastic volume strain.
b = 0: Wilkins' radial return. The usual form sqrt(J2) + alpha I1 = k has alpha = a / (3 sqrt 3), k = Y / sqrt 3.
Source: D. C. Drucker, W. Prager, Q. Appl. Math. 10 (1952) 157; the return as in E. A. de Souza Neto, D. Peric, D. R. J. Owen,
Computational Methods for Plasticity (2008), section 8.3.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from pydantic import model_validator

from ..errors import ParameterError
from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .plastic_law import PlasticLaw, ReturnedStress, return_stress, yield_limit


class DruckerPragerConstants(NamedTuple):
    """Yield stress Y [Pa], hardening H [Pa], friction a, dilatancy b."""

    yield_stress: float
    hardening: float
    friction: float
    dilatancy: float


class DruckerPrager(PlasticLaw):
    """q <= yield_stress + hardening x equivalent plastic strain + friction x pressure."""

    name: Literal["drucker_prager"] = field("drucker_prager", "soils and rocks: strength grows with pressure", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at first yield at zero pressure", "Pa")
    friction: float = field(..., "increase of the yield stress with pressure", "1", gt=0.0, lt=3.0)
    dilatancy: float = field(0.0, "plastic volume strain per equivalent plastic strain", "1", ge=0.0, lt=3.0)
    hardening: NotNegativeMagnitude = field(0.0, "increase of the yield stress with equivalent plastic strain", "Pa")

    @model_validator(mode="after")
    def _validate_dilatancy(self) -> DruckerPrager:
        if self.dilatancy > self.friction:
            raise ParameterError(
                f"got {self.dilatancy:g}",
                expected=f"at most friction = {self.friction:g}: more would generate energy",
                at="dilatancy",
            )
        return self

    def constants(self) -> DruckerPragerConstants:
        """Return Y, H, a and b."""
        return DruckerPragerConstants(self.yield_stress, self.hardening, self.friction, self.dilatancy)


@yield_limit.register(DruckerPragerConstants)
def _yield_limit(law, plastic_strain, pressure):
    return law.yield_stress + law.hardening * plastic_strain + law.friction * pressure


@return_stress.register(DruckerPragerConstants)
def _return_stress(law, moduli, plastic_strain, equivalent, pressure):
    strength = law.yield_stress + law.hardening * plastic_strain
    bulk = moduli.first_lame + 2.0 * moduli.shear / 3.0
    beyond = equivalent - strength - law.friction * pressure
    if beyond <= 0.0:
        return ReturnedStress(0.0, equivalent, pressure)
    strain = beyond / (3.0 * moduli.shear + bulk * law.friction * law.dilatancy + law.hardening)
    left = equivalent - 3.0 * moduli.shear * strain
    if left >= 0.0:
        return ReturnedStress(strain, left, pressure + bulk * law.dilatancy * strain)
    # Beyond the tip the deviator vanishes and the pressure returns to the tip. The opening counts as plastic strain, and
    # hardening moves the tip by H / a times that strain.
    strain = equivalent / (3.0 * moduli.shear) + (-strength / law.friction - pressure) / bulk
    strain /= 1.0 + law.hardening / (law.friction * bulk)
    return ReturnedStress(strain, 0.0, -(strength + law.hardening * strain) / law.friction)
