"""Laws by which broken pairs are linked again, one a file. A new one is a file and a line in `RELINKINGS`."""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import ByName
from .cold_welding import ColdWelding
from .relinking import Never, Relinking

__all__ = ["RELINKINGS", "ChosenRelinking", "ColdWelding", "Never", "Relinking"]

RELINKINGS: dict[str, type[Relinking]] = {"none": Never, "cold_welding": ColdWelding}

ChosenRelinking = Annotated[SerializeAsAny[Relinking], ByName(RELINKINGS)]
