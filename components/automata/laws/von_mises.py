"""Von Mises: a pair breaks when its equivalent stress reaches the strength, equal in tension and compression."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...support.parameter_fields import Magnitude, field
from .criterion import Criterion, failure_measure


class VonMisesLaw(NamedTuple):
    """The strength [Pa]."""

    strength: float


class VonMises(Criterion):
    """sigma_eq >= strength."""

    name: Literal["von_mises"] = field("von_mises", "which criterion", "1")
    strength: Magnitude = field(..., "equivalent stress at which a pair breaks", "Pa")
    causes = {"von_mises_break": "the equivalent stress of a pair reached its strength"}

    def constants(self) -> VonMisesLaw:
        """Return the strength."""
        return VonMisesLaw(self.strength)


@failure_measure.register(VonMisesLaw)
def _von_mises_measure(law, link):
    return link.equivalent, link.factor * law.strength, 0
