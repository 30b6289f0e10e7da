"""The base of breaking criteria: their constants, and the causes that they know."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Literal

from ...support.parameter_fields import field
from ...support.tagged_union import Named

# Numbers of the criteria in kernels; see `dispatch.failure`.
NONE, VON_MISES, DRUCKER_PRAGER, MOHR_COULOMB, STRAIN = range(5)


class Criterion(Named):
    """A condition under which a linked pair breaks."""

    code: ClassVar[int]
    """Number by which kernels know it."""
    causes: ClassVar[Mapping[str, str]]
    """Kinds of events, in the order in which the kernel numbers its causes -> what happened."""
    unit: ClassVar[str] = "Pa"
    """Unit of what decides and of its limit."""

    def constants(self) -> tuple[float, float, float]:
        """Return what the kernel's function takes."""
        return 0.0, 0.0, 0.0

    def unbreakable_constants(self) -> tuple[float, float, float]:
        """Return what the kernel's function takes where nothing breaks: no limit is ever reached."""
        return math.inf, math.inf, math.inf


class Unbreakable(Criterion):
    """Pairs stay linked."""

    name: Literal["none"] = field("none", "which criterion", "1")
    code = NONE
    causes = {}
