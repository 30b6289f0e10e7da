"""Mohr-Coulomb on the face of a pair, with a tension cut-off.

    |tau| + sigma_n tan(phi) >= cohesion        or        sigma_n >= tensile strength

tau and sigma_n are the tractions on the face of the pair, so the orientation of the pair matters too. Jaeger, Cook & Zimmerman
(2007), Fundamentals of Rock Mechanics, section 4.5.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .criterion import Criterion, failure_measure


class MohrCoulombLaw(NamedTuple):
    """Cohesion [Pa], tan(phi) and tensile strength [Pa]."""

    cohesion: float
    internal_friction: float
    tensile: float


class MohrCoulomb(Criterion):
    """|tau| + sigma_n x internal_friction >= cohesion, or sigma_n >= tensile strength."""

    name: Literal["mohr_coulomb"] = field("mohr_coulomb", "which criterion", "1")
    cohesion: Magnitude = field(..., "shear traction at which a pair without pressure breaks", "Pa")
    internal_friction: NotNegativeMagnitude = field(..., "increase of the shear strength per pressure, tan(phi)", "1")
    tensile: Magnitude = field(..., "tensile traction at which a pair breaks", "Pa")
    causes = {
        "shear_break": "the shear traction of a pair reached its cohesion plus internal friction",
        "tension_break": "the tensile traction of a pair reached its strength",
    }

    def constants(self) -> MohrCoulombLaw:
        """Return cohesion, tan(phi) and the tensile strength."""
        return MohrCoulombLaw(self.cohesion, self.internal_friction, self.tensile)

    def unbreakable_constants(self) -> MohrCoulombLaw:
        """Return infinite strengths and tan(phi) = 0."""
        return MohrCoulombLaw(math.inf, 0.0, math.inf)


@failure_measure.register(MohrCoulombLaw)
def _mohr_coulomb_measure(law, link):
    """Return the quantity, limit and number of the cause that is closer to its limit: shear or tension."""
    shear = abs(link.tangential) + law.internal_friction * link.normal
    if link.normal * law.cohesion >= shear * law.tensile:
        return link.normal, link.factor * law.tensile, 1
    return shear, link.factor * law.cohesion, 0
