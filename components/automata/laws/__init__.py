"""Laws of linked pairs: the responses, and the breaking criteria, one module each (parameters, formula, source).

A new criterion needs a module and an entry in `CRITERIA`.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import ByName, OneOrEach
from .criterion import Criterion, Unbreakable
from .drucker_prager import DruckerPrager
from .mohr_coulomb import MohrCoulomb
from .strain import Strain
from .von_mises import VonMises

__all__ = [
    "CRITERIA",
    "ChosenCriteria",
    "ChosenCriterion",
    "Criterion",
    "DruckerPrager",
    "MohrCoulomb",
    "Strain",
    "Unbreakable",
    "VonMises",
]

CRITERIA: dict[str, type[Criterion]] = {
    "none": Unbreakable,
    "von_mises": VonMises,
    "drucker_prager": DruckerPrager,
    "mohr_coulomb": MohrCoulomb,
    "strain": Strain,
}

ChosenCriterion = Annotated[SerializeAsAny[Criterion], ByName(CRITERIA)]
ChosenCriteria = Annotated[SerializeAsAny[Criterion] | list[SerializeAsAny[Criterion]], OneOrEach(CRITERIA)]
