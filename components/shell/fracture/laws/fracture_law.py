"""The base class of fracture laws, and the kernel functions of a law.

`constants` returns the law for kernels: a named tuple, whose class selects `decisive_value` and `may_exceed`.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ....materials.thermoviscoplastic import FlowConstants
from ....support.counter_random import uniform
from ....support.dispatch import dispatch_by_class
from ....support.float_arrays import FloatArray
from ....support.parameter_fields import NotNegativeMagnitude, field
from ....support.tagged_union import Named

_STREAM = 3


class Point(NamedTuple):
    """The quantities of an integration point that a law uses.

    Attributes:
        principal: largest principal Kirchhoff stress [Pa].
        volume: volume over initial volume.
        plastic_strain: equivalent plastic strain; 0 for an elastic body.
    """

    principal: float
    volume: float
    plastic_strain: float


@dispatch_by_class
def decisive_value(law, point):
    """Return for a `Point` the value that the law compares with its limit."""


@dispatch_by_class
def may_exceed(law, value, stress, plastic_strain):
    """Return False if a cheap bound shows that the value that the law tests cannot be above `value`.

    Args:
        law: constants of a fracture law.
        value: value to compare with, in the unit of the limit.
        stress: Kirchhoff stress of the point, a `SymmetricTensor` [Pa].
        plastic_strain: plastic strain of the point.
    """


class FractureLaw(Named):
    """A condition under which a point cracks, chosen by its `name`; the crack is normal to the largest principal stress."""

    unit: ClassVar[str]
    quantity: ClassVar[str]
    scatter: float = field(
        0.0, "largest relative deviation of the strength of a column of points from the mean", "1", ge=0.0, lt=1.0
    )
    seed: int = field(1, "seed of the scatter", "1", ge=0, lt=2**63)
    grip_length: NotNegativeMagnitude = field(
        0.0, "length at clamped and moved edges, i.e. in the grips, within which no point parts", "m"
    )

    @property
    def needs_flow(self) -> bool:
        """Whether the law needs a material with plastic flow, for its plastic strain or yield stress."""
        return False

    @abstractmethod
    def limit(self, law: FlowConstants) -> float:
        """Return the limit at which a point cracks, in `unit`."""

    @abstractmethod
    def constants(self, law: FlowConstants) -> Any:
        """Return the law for kernels, a named tuple."""

    def limits(self, law: FlowConstants, columns: int, through: int) -> FloatArray:
        """Return the limit of each point, equal for all points of a column, shape (columns * through,)."""
        spread = 1.0 + self.scatter * (2.0 * uniform(self.seed, _STREAM, columns) - 1.0)
        return np.repeat(self.limit(law) * spread, through)
