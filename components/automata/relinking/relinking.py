"""The base of laws by which broken pairs are linked again: when a contact becomes a link."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from ...support.parameter_fields import field
from ...support.tagged_union import Named


class Relinking(Named):
    """A condition under which a pair that has broken is linked again."""

    kinds: ClassVar[Mapping[str, str]] = {}
    """Kind of its events -> what happened."""

    def constants(self) -> tuple[float, float]:
        """Return the least pressure [Pa] and the largest sliding speed [m/s]."""
        return 0.0, 0.0


class Never(Relinking):
    """No law: pairs stay broken."""

    name: Literal["none"] = field("none", "which law", "1")
