"""Hertz with a dashpot: F = k d^1.5 + c dd/dt while the spheres touch, and never a pull.

The simplest dissipation there is, and the wrong one for spheres: it loses more at low speed, 1 - e ~ v^(-1/5). P. A. Cundall,
O. D. L. Strack, Geotechnique 29 (1979) 47, with Hertz's spring in the place of their linear one.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ...support.jit import inlined
from ..fields import NotNegative, field
from ..layout import HERTZ, SMALLEST_OVERLAP, VISCOUS
from .law import Dissipative, FloatArray


class Viscous(Dissipative):
    """F = k d^1.5 + dissipation x dd/dt while d > 0, cut off at 0."""

    exponent: ClassVar[float] = 1.5
    elastic, damping, jumps = HERTZ, VISCOUS, True

    name: Literal["viscous"] = field("viscous", "Hertz with a dashpot", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "c: one for all contacts, or one for each place", "N s/m")

    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """The dissipation itself."""
        return constants

    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """At once, or never."""
        return np.where(constants > coefficients, 0.0, np.inf)


@inlined
def coefficient(c, d):
    """Force per speed of approach: c while they touch."""
    return c if d > 0.0 else 0.0


# A contact that closes where two steps meet, as round numbers make it, closes in the second: its slope is found there, once.
_EDGE = 1e-3


@inlined
def is_closing(d, w, h):
    """Whether a contact closes within a step of length h, d being its overlap in the middle and w its speed of approach."""
    reach = 0.5 * h * w
    return reach > SMALLEST_OVERLAP and -(1.0 - _EDGE) * reach < d <= (1.0 + _EDGE) * reach


@inlined
def closed_time(d, w, h):
    """The part of a step in which a contact is closed; from where it closes, if it does so within the step.

    Without that the dashpot's impulse would jump wherever the closing passes from one step to the next, the order would be 1
    where contacts close, and slopes of the run would be those between two jumps, which no step makes right.
    """
    whole = h if d >= SMALLEST_OVERLAP else 0.0
    return 0.5 * h + d / w if is_closing(d, w, h) else whole
