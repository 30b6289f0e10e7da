"""No reaction."""

from __future__ import annotations

from typing import ClassVar, Literal

from ...support.parameter_fields import field
from .reaction import INERT, Reaction


class Inert(Reaction):
    """A gas that does not react."""

    code: ClassVar[int] = INERT
    name: Literal["inert"] = field("inert", "no reaction", "1")
