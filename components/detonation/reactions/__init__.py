"""Reaction laws by name, one module each."""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import ByName
from .arrhenius import Arrhenius
from .constant_volume import ConstantVolume
from .inert import Inert
from .pressure_burn import PressureBurn
from .reaction import Reaction

REACTIONS: dict[str, type[Reaction]] = {
    "inert": Inert,
    "pressure_burn": PressureBurn,
    "arrhenius": Arrhenius,
    "constant_volume": ConstantVolume,
}
ChosenReaction = Annotated[SerializeAsAny[Reaction], ByName(REACTIONS)]

__all__ = ["REACTIONS", "Arrhenius", "ChosenReaction", "ConstantVolume", "Inert", "PressureBurn", "Reaction"]
