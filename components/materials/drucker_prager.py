"""Drucker-Prager plasticity with a flow rule of its own and linear hardening, by return to the cone or to its tip.

q <= Y + H e + a p, p the pressure (positive in compression), a the friction; the flow dilates: the plastic volume strain is b
times the equivalent plastic strain e, b the dilatancy. A trial stress outside goes back by
e' = (q - Y - H e - a p) / (3 mu + K a b + H), q -> q - 3 mu e', p -> p + K b e'; where that would pass the tip of the cone, to
the tip p = -(Y + H e) / a, and e grows by q / 3 mu and by the plastic volume strain. With b = 0 the return is Wilkins' radial
one, with a = 0 too that of von Mises. The usual sqrt(J2) + alpha I1 = k has alpha = a / (3 sqrt 3), k = Y / sqrt 3.
Source: D. C. Drucker, W. Prager, Q. Appl. Math. 10 (1952) 157; the return as in E. A. de Souza Neto, D. Peric, D. R. J. Owen,
Computational Methods for Plasticity (2008), section 8.3.
"""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ..errors import ParameterError
from ..support.jit import inlined
from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .plastic_law import PlasticLaw


class DruckerPrager(PlasticLaw):
    """q <= yield_stress + hardening x equivalent plastic strain + friction x pressure."""

    name: Literal["drucker_prager"] = field("drucker_prager", "soils and rocks: strength grows with pressure", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at first yield where the pressure is 0", "Pa")
    friction: float = field(..., "increase of the yield stress with pressure", "1", gt=0.0, lt=3.0)
    dilatancy: float = field(0.0, "plastic volume strain per equivalent plastic strain", "1", ge=0.0, lt=3.0)
    hardening: NotNegativeMagnitude = field(0.0, "increase of the yield stress with equivalent plastic strain", "Pa")

    @model_validator(mode="after")
    def _validate_dilatancy(self) -> DruckerPrager:
        if self.dilatancy > self.friction:
            raise ParameterError(
                f"got {self.dilatancy:g}",
                expected=f"at most friction = {self.friction:g}: more would give energy",
                at="dilatancy",
            )
        return self

    def constants(self) -> tuple[float, float, float, float]:
        """Return yield stress, hardening, friction, dilatancy."""
        return self.yield_stress, self.hardening, self.friction, self.dilatancy


@inlined
def return_to_cone(equivalent, pressure, strength, bulk, shear, hardening, friction, dilatancy):
    """Return the equivalent plastic strain, and q and p [Pa] after the return; 0 and the trial's own inside.

    Args:
        equivalent: q of the trial stress [Pa].
        pressure: p of the trial stress [Pa].
        strength: yield stress at no pressure now [Pa].
        bulk: bulk modulus [Pa].
        shear: shear modulus [Pa].
        hardening: slope of the yield stress [Pa].
        friction: a.
        dilatancy: b.
    """
    beyond = equivalent - strength - friction * pressure
    if beyond <= 0.0:
        return 0.0, equivalent, pressure
    strain = beyond / (3.0 * shear + bulk * friction * dilatancy + hardening)
    left = equivalent - 3.0 * shear * strain
    if left >= 0.0:
        return strain, left, pressure + bulk * dilatancy * strain
    # Past the tip: what deviator there is goes, and the pressure returns to the tip. What opens there counts as plastic too,
    # and hardening moves the tip by H / a times that.
    strain = equivalent / (3.0 * shear) + (-strength / friction - pressure) / bulk
    strain /= 1.0 + hardening / (friction * bulk)
    return strain, 0.0, -(strength + hardening * strain) / friction
