"""The base of the plastic laws: what a law declares, and what kernels get of it."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field

from ..support.tagged_union import Named

# How many constants kernels get of each law.
LAW_CONSTANTS = 4
# Codes of the laws, for kernels.
ELASTIC, VON_MISES, DRUCKER_PRAGER = range(3)


def number(default: Any, description: str, unit: str, **bounds: Any) -> Any:
    """Return a field of a law with its meaning and unit."""
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)


class PlasticLaw(Named):
    """A law of when and how a material yields, chosen by its `name`."""

    code: ClassVar[int]
    """Which return of the stress to the yield surface kernels take."""

    def constants(self) -> tuple[float, float, float, float]:
        """Return what kernels want to know: yield stress [Pa], hardening [Pa], friction, dilatancy."""
        raise NotImplementedError


class Elastic(PlasticLaw):
    """A material that never yields."""

    code: ClassVar[int] = ELASTIC
    name: Literal["elastic"] = number("elastic", "a material that never yields", "1")

    def constants(self) -> tuple[float, float, float, float]:
        """Return zeros."""
        return 0.0, 0.0, 0.0, 0.0
