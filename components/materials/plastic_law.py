"""The base of the plastic laws: what a law declares, and what kernels get of it."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

from ..support.parameter_fields import field
from ..support.tagged_union import Named

# How many constants kernels get of each law.
LAW_CONSTANTS = 4
# Codes of the laws, for kernels.
ELASTIC, VON_MISES, DRUCKER_PRAGER = range(3)


class PlasticLaw(Named):
    """A law of when and how a material yields, chosen by its `name`."""

    code: ClassVar[int]
    """Which return of the stress to the yield surface kernels take."""

    @abstractmethod
    def constants(self) -> tuple[float, float, float, float]:
        """Return what kernels want to know: yield stress [Pa], hardening [Pa], friction, dilatancy."""


class Elastic(PlasticLaw):
    """A material that never yields."""

    code: ClassVar[int] = ELASTIC
    name: Literal["elastic"] = field("elastic", "a material that never yields", "1")

    def constants(self) -> tuple[float, float, float, float]:
        """Return zeros."""
        return 0.0, 0.0, 0.0, 0.0
