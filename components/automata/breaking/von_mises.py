"""Von Mises: a pair breaks when its equivalent stress reaches a strength; equally strong in tension and compression."""

from __future__ import annotations

from typing import Literal

from ...support.jit import internal_inlined
from ...support.parameter_fields import Magnitude, field
from .criterion import VON_MISES, Criterion


class VonMises(Criterion):
    """sigma_eq >= strength."""

    name: Literal["von_mises"] = field("von_mises", "which criterion", "1")
    strength: Magnitude = field(..., "equivalent stress that breaks a pair", "Pa")
    code = VON_MISES
    causes = {"von_mises_break": "the equivalent stress of a pair reached its strength"}

    def constants(self) -> tuple[float, float, float]:
        """Return the strength."""
        return self.strength, 0.0, 0.0


@internal_inlined
def von_mises(equivalent, strength, factor):
    """Return the value, the limit and the cause."""
    return equivalent, factor * strength, 0
