"""Plastic laws by name, one module each: elastic (none), von Mises, Drucker-Prager. A new law needs a module and an entry."""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ..support.tagged_union import ByName
from .drucker_prager import DruckerPrager
from .plastic_law import Elastic, PlasticLaw
from .von_mises import VonMises

__all__ = ["PLASTIC_LAWS", "ChosenPlasticity", "DruckerPrager", "Elastic", "PlasticLaw", "VonMises"]

PLASTIC_LAWS: dict[str, type[PlasticLaw]] = {"elastic": Elastic, "von_mises": VonMises, "drucker_prager": DruckerPrager}

ChosenPlasticity = Annotated[SerializeAsAny[PlasticLaw], ByName(PLASTIC_LAWS)]
