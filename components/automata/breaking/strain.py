"""Strain of a pair: the overlap parameter of the paper, linked while h = r - r0 < h_max, and a limit of the shear angle."""

from __future__ import annotations

from typing import Literal

from ...support.jit import internal_inlined
from ...support.parameter_fields import MOST, Magnitude, field
from .criterion import STRAIN, Criterion


class Strain(Criterion):
    """eps >= tensile, or |gamma| >= shear."""

    name: Literal["strain"] = field("strain", "which criterion", "1")
    tensile: Magnitude = field(..., "strain h_max / r0 along a pair that breaks it", "1")
    shear: Magnitude = field(MOST, "shear angle that breaks a pair", "1")
    code = STRAIN
    unit = "1"
    causes = {
        "stretch_break": "the strain along a pair reached its limit",
        "angle_break": "the shear angle of a pair reached its limit",
    }

    def constants(self) -> tuple[float, float, float]:
        """Return both limits."""
        return self.tensile, self.shear, 0.0


@internal_inlined
def strain(eps, gamma, tensile, shear, factor):
    """Return the value, the limit and the cause, that which is exceeded by the larger part."""
    if abs(gamma) / shear > eps / tensile:
        return abs(gamma), factor * shear, 1
    return eps, factor * tensile, 0
