"""A general exponent, F = k d^p: p = 1 linear springs without tension, 1.5 spheres, 2 cones, others for other tips and shells.

V. F. Nesterenko, Dynamics of Heterogeneous Materials (Springer 2001), section 1.6: solitary waves exist for every p > 1, and
their width depends on p alone.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...support.jit import inlined
from ...support.powers import power
from ..fields import field
from ..layout import POWER, SMALLEST_OVERLAP
from .law import FloatArray, Law


class Power(Law):
    """F = k d^exponent, k the parameter `contact_stiffness` in N/m^exponent, which has to be given."""

    elastic = POWER
    needs_stiffness = True

    name: Literal["power"] = field("power", "a general exponent", "1")
    exponent: float = field(  # pyright: ignore[reportIncompatibleVariableOverride]
        ..., "p of F = k d^p", "1", ge=1.0, le=10.0
    )

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """(F / k)^(1/p)."""
        ratio = force / stiffness
        return np.array([power(value, 1.0 / self.exponent) if value > SMALLEST_OVERLAP else 0.0 for value in ratio])


@inlined
def force(k, d, p):
    """F = k d^p for d > 0, else 0."""
    pressed = d if d > SMALLEST_OVERLAP else SMALLEST_OVERLAP
    return k * power(pressed, p) if d > SMALLEST_OVERLAP else 0.0 * d


@inlined
def energy(k, d, p):
    """Its work up to the overlap d: k d^(p + 1) / (p + 1)."""
    pressed = d if d > SMALLEST_OVERLAP else SMALLEST_OVERLAP
    return k * (d * power(pressed, p)) / (p + 1.0) if d > SMALLEST_OVERLAP else 0.0 * d
