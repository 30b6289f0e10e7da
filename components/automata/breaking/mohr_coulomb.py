"""Mohr and Coulomb on the face of a pair, with a tension cut-off.

    |tau| + sigma_n tan(phi) >= cohesion        or        sigma_n >= tensile strength

tau and sigma_n are the tractions on the pair's own face, so that it also matters how a pair lies. Jaeger, Cook & Zimmerman
(2007), Fundamentals of Rock Mechanics, section 4.5.
"""

from __future__ import annotations

import math
from typing import Literal

from ...support.jit import internal_inlined
from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .criterion import MOHR_COULOMB, Criterion


class MohrCoulomb(Criterion):
    """|tau| + sigma_n x internal_friction >= cohesion, or sigma_n >= tensile strength."""

    name: Literal["mohr_coulomb"] = field("mohr_coulomb", "which criterion", "1")
    cohesion: Magnitude = field(..., "shear traction that breaks a pair without pressure", "Pa")
    internal_friction: NotNegativeMagnitude = field(..., "how the shear strength grows with pressure, tan(phi)", "1")
    tensile: Magnitude = field(..., "normal traction that breaks a pair", "Pa")
    code = MOHR_COULOMB
    causes = {
        "shear_break": "the shear traction of a pair reached its cohesion and internal friction",
        "tension_break": "the tension of a pair reached its strength",
    }

    def constants(self) -> tuple[float, float, float]:
        """Return cohesion, tan(phi) and the tensile strength."""
        return self.cohesion, self.internal_friction, self.tensile

    def unbreakable_constants(self) -> tuple[float, float, float]:
        """Return strengths without end, and no part of the stress beside them."""
        return math.inf, 0.0, math.inf


@internal_inlined
def mohr_coulomb(normal, tangential, cohesion, internal_friction, tensile, factor):
    """Return the value, the limit and the cause, that which is exceeded by the larger part."""
    shear = abs(tangential) + internal_friction * normal
    if normal * cohesion >= shear * tensile:
        return normal, factor * tensile, 1
    return shear, factor * cohesion, 0
