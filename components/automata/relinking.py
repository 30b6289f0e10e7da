"""Laws by which broken pairs are linked again; see `welding` for the kernels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import SerializeAsAny

from ..support.parameter_fields import Magnitude, field
from ..support.tagged_union import ByName, Named


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


class ColdWelding(Relinking):
    """Pressure of the contact >= pressure, and sliding speed <= slip_speed; looked at every `release_ticks` steps."""

    name: Literal["cold_welding"] = field("cold_welding", "which law", "1")
    pressure: Magnitude = field(..., "pressure of a contact that links it", "Pa")
    slip_speed: Magnitude = field(..., "largest sliding speed at which it does", "m/s")
    kinds = {"linked": "a broken pair was pressed as hard as its law says, and was linked again"}

    def constants(self) -> tuple[float, float]:
        """Return pressure and speed."""
        return self.pressure, self.slip_speed


RELINKINGS: dict[str, type[Relinking]] = {"none": Never, "cold_welding": ColdWelding}

ChosenRelinking = Annotated[SerializeAsAny[Relinking], ByName(RELINKINGS)]
