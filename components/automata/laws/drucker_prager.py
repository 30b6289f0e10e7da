"""Drucker and Prager: the strength increases with pressure.

    ((a + 1) / 2) sigma_eq + (3 / 2) (a - 1) sigma_m >= sigma_c,        a = sigma_c / sigma_t

Uniaxial compression breaks a pair at sigma_c, uniaxial tension at sigma_t. Drucker & Prager (1952), Q. Appl. Math. 10, 157.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from pydantic import model_validator

from ...errors import ParameterError
from ...support.parameter_fields import Magnitude, field
from .criterion import Criterion, failure_measure


class DruckerPragerLaw(NamedTuple):
    """The strength sigma_c [Pa], and the factors of sigma_eq and of sigma_m in the criterion."""

    strength: float
    of_equivalent: float
    of_mean: float


class DruckerPrager(Criterion):
    """((a + 1) / 2) sigma_eq + 1.5 (a - 1) sigma_m >= compressive strength."""

    name: Literal["drucker_prager"] = field("drucker_prager", "which criterion", "1")
    compressive: Magnitude = field(..., "strength in uniaxial compression", "Pa")
    tensile: Magnitude = field(..., "strength in uniaxial tension", "Pa")
    causes = {"drucker_prager_break": "the stress of a pair reached its Drucker-Prager strength"}

    @model_validator(mode="after")
    def _validate_order(self) -> DruckerPrager:
        if self.compressive < self.tensile:
            raise ParameterError(
                f"got {self.compressive:g} Pa", expected=f"at least tensile = {self.tensile:g} Pa", at="compressive"
            )
        return self

    def constants(self) -> DruckerPragerLaw:
        """Return sigma_c and the factors of sigma_eq and sigma_m."""
        a = self.compressive / self.tensile
        return DruckerPragerLaw(self.compressive, 0.5 * (a + 1.0), 1.5 * (a - 1.0))

    def unbreakable_constants(self) -> DruckerPragerLaw:
        """Return an infinite strength, and factors 0 for both stresses."""
        return DruckerPragerLaw(math.inf, 0.0, 0.0)


@failure_measure.register(DruckerPragerLaw)
def _drucker_prager_measure(law, link):
    return law.of_equivalent * link.equivalent + law.of_mean * link.mean, link.factor * law.strength, 0
