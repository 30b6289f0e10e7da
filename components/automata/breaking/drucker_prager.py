"""Drucker and Prager: the strength grows with pressure.

    ((a + 1) / 2) sigma_eq + (3 / 2) (a - 1) sigma_m >= sigma_c,        a = sigma_c / sigma_t

so that uniaxial compression breaks at sigma_c and uniaxial tension at sigma_t. Drucker & Prager (1952), Q. Appl. Math. 10, 157.
"""

from __future__ import annotations

import math
from typing import Literal

from pydantic import model_validator

from ...support.jit import internal_inlined
from ...support.parameter_fields import Magnitude, field
from ...support.validation import refusal
from .criterion import DRUCKER_PRAGER, Criterion


class DruckerPrager(Criterion):
    """((a + 1) / 2) sigma_eq + 1.5 (a - 1) sigma_m >= compressive strength."""

    name: Literal["drucker_prager"] = field("drucker_prager", "which criterion", "1")
    compressive: Magnitude = field(..., "strength in uniaxial compression", "Pa")
    tensile: Magnitude = field(..., "strength in uniaxial tension", "Pa")
    code = DRUCKER_PRAGER
    causes = {"drucker_prager_break": "the stress of a pair reached the criterion of Drucker and Prager"}

    @model_validator(mode="after")
    def _validate_order(self) -> DruckerPrager:
        if self.compressive < self.tensile:
            raise refusal(f"got {self.compressive:g} Pa", f"at least tensile = {self.tensile:g} Pa", at=("compressive",))
        return self

    def constants(self) -> tuple[float, float, float]:
        """Return sigma_c, and the factors of the equivalent and of the mean stress."""
        a = self.compressive / self.tensile
        return self.compressive, 0.5 * (a + 1.0), 1.5 * (a - 1.0)

    def unbreakable_constants(self) -> tuple[float, float, float]:
        """Return strengths without end, and no part of the stress beside them."""
        return math.inf, 0.0, 0.0


@internal_inlined
def drucker_prager(equivalent, mean, strength, of_equivalent, of_mean, factor):
    """Return the value, the limit and the cause."""
    return of_equivalent * equivalent + of_mean * mean, factor * strength, 0
