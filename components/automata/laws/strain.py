"""Strain criterion: a pair breaks if its overlap parameter h = r - r0 of the paper, or its shear angle, reaches a limit."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...support.parameter_fields import MOST, Magnitude, field
from .criterion import Criterion, failure_measure


class StrainLaw(NamedTuple):
    """Limits of the strain along a pair and of the shear angle."""

    tensile: float
    shear: float


class Strain(Criterion):
    """eps >= tensile, or |gamma| >= shear."""

    name: Literal["strain"] = field("strain", "which criterion", "1")
    tensile: Magnitude = field(..., "strain h_max / r0 along a pair at which it breaks", "1")
    shear: Magnitude = field(MOST, "shear angle at which a pair breaks", "1")
    unit = "1"
    causes = {
        "stretch_break": "the strain along a pair reached its limit",
        "angle_break": "the shear angle of a pair reached its limit",
    }

    def constants(self) -> StrainLaw:
        """Return both limits."""
        return StrainLaw(self.tensile, self.shear)


@failure_measure.register(StrainLaw)
def _strain_measure(law, link):
    """Return the quantity, limit and number of the cause that is closer to its limit: strain or shear angle."""
    if abs(link.gamma) / law.shear > link.eps / law.tensile:
        return abs(link.gamma), link.factor * law.shear, 1
    return link.eps, link.factor * law.tensile, 0
