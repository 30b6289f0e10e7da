"""The base of fracture laws."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, ClassVar

import numpy as np

from ...materials.thermoviscoplastic import FlowConstants
from ...support.counter_random import uniform
from ...support.float_arrays import FloatArray
from ...support.parameter_fields import NotNegativeMagnitude, field
from ...support.tagged_union import Named

_STREAM = 3


class Decisive(IntEnum):
    """The quantities that the kernels can compare with the limit of a law."""

    PRINCIPAL_STRESS = 0
    PLASTIC_STRAIN = 1


class FractureLaw(Named):
    """A law of when a point parts, chosen by its `name`; its crack is normal to the largest principal stress."""

    decisive: ClassVar[Decisive]
    unit: ClassVar[str]
    quantity: ClassVar[str]
    scatter: float = field(
        0.0, "largest deviation of the strength of a column of points from the mean, over it", "1", ge=0.0, lt=1.0
    )
    seed: int = field(1, "of the scatter", "1", ge=0, lt=2**63)
    grip_length: NotNegativeMagnitude = field(
        0.0, "length beside clamped and moved edges within which nothing parts, as a fitting holds it there", "m"
    )

    def __init_subclass__(cls, **arguments: Any) -> None:
        """Refuse a law that is decided by what no kernel computes: another one would stand in for it.

        Raises:
            TypeError: `decisive` is none of `Decisive`.
        """
        super().__init_subclass__(**arguments)
        given = getattr(cls, "decisive", None)
        if not isinstance(given, Decisive):
            raise TypeError(
                f"{cls.__name__}.decisive: got {given!r}, expected one of {', '.join(Decisive.__members__)}; another quantity "
                "needs a member of Decisive and a branch in criterion_evaluation.decisive_value"
            )

    @property
    def needs_flow(self) -> bool:
        """True where it asks for a material that flows: for its plastic strain, or its yield stress."""
        return False

    def limit(self, law: FlowConstants) -> float:
        """Return what decides where a point parts, in `unit`."""
        raise NotImplementedError

    def limits(self, law: FlowConstants, columns: int, through: int) -> FloatArray:
        """Return the limit of each point, the same for all of a column, shape (columns * through,)."""
        spread = 1.0 + self.scatter * (2.0 * uniform(self.seed, _STREAM, columns) - 1.0)
        return np.repeat(self.limit(law) * spread, through)
