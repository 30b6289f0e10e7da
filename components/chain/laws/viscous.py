"""Hertz with a dashpot: F = k d^1.5 + c dd/dt while the spheres touch, and never a pull.

The simplest dissipation there is, and the wrong one for spheres: it loses more at low speed, 1 - e ~ v^(-1/5). P. A. Cundall,
O. D. L. Strack, Geotechnique 29 (1979) 47, with Hertz's spring in the place of their linear one.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ...support.jit import inlined
from ...support.parameter_fields import NotNegative, field
from ..layout import LAW_CONSTANTS
from .hertz import HertzRest, energy, energy_pullback, energy_root, energy_root_pullback, force, force_slopes
from .law import Dissipative, FloatArray

__all__ = [
    "Viscous", "coefficient", "coefficient_pullback", "energy", "energy_pullback", "energy_root", "energy_root_pullback",
    "force", "force_slopes",
]  # fmt: skip


class Viscous(HertzRest, Dissipative):
    """F = k d^1.5 + dissipation x dd/dt while d > 0, cut off at 0."""

    jumps: ClassVar[bool] = True

    name: Literal["viscous"] = field("viscous", "Hertz with a dashpot", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "c: one for all contacts, or one for each place", "N s/m")

    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return the dissipation itself."""
        return constants[:, 0]

    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return 0 or infinity: at once, or never."""
        return np.where(constants[:, 0] > coefficients, 0.0, np.inf)


@inlined
def coefficient(a, j, d):
    """Return c."""
    return a[LAW_CONSTANTS, j]


@inlined
def coefficient_pullback(a, adjoint, j, d, slope):
    """Add slope to the derivative by c; the overlap does not matter."""
    adjoint[LAW_CONSTANTS, j] += slope
    return 0.0
