"""The base of the plastic laws: a law is the constants of one yield condition, so that kernels choose among none.

q <= Y + H e + a p, with the plastic volume strain b e; `drucker_prager` has the return of a stress that is outside.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Literal

from ..support.parameter_fields import field
from ..support.tagged_union import Named


class PlasticLaw(Named):
    """A law of when and how a material yields, chosen by its `name`."""

    @abstractmethod
    def constants(self) -> tuple[float, float, float, float]:
        """Return yield stress Y [Pa], hardening H [Pa], friction a, dilatancy b; an infinite Y where nothing yields."""


class Elastic(PlasticLaw):
    """A material that never yields."""

    name: Literal["elastic"] = field("elastic", "a material that never yields", "1")

    def constants(self) -> tuple[float, float, float, float]:
        """Return a yield stress that nothing reaches."""
        return math.inf, 0.0, 0.0, 0.0
