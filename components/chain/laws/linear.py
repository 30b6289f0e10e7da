"""A linear spring and dashpot: F = k d + c dd/dt while the grains touch, and never a pull.

P. A. Cundall, O. D. L. Strack, Geotechnique 29 (1979) 47, the contact of most discrete element codes. With
zeta = c / (2 sqrt(k m*)), m* the reduced mass, a contact that may pull has the restitution exp(-pi zeta / sqrt(1 - zeta^2)) at
any speed; one that opens where its force is 0 has more: T. Schwager, T. Poeschel, Granular Matter 9 (2007) 465, eq. (10).
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ...support.jit import inlined
from ...support.parameter_fields import NotNegative, field
from ..layout import LAW_CONSTANTS, STIFFNESS
from .law import Dissipative, FloatArray


class Linear(Dissipative):
    """F = k d + dissipation x dd/dt while d > 0, cut off at 0; k is the parameter `contact_stiffness`, in N/m."""

    exponent: ClassVar[float] = 1.0
    needs_stiffness: ClassVar[bool] = True
    jumps: ClassVar[bool] = True

    name: Literal["linear"] = field("linear", "a linear spring and dashpot", "1")
    dissipation: NotNegative | list[NotNegative] = field(0.0, "c: one for all contacts, or one for each place", "N s/m")

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return F / k."""
        return force / stiffness

    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return the dissipation itself."""
        return constants[:, 0]

    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return 0 or infinity: at once, or never."""
        return np.where(constants[:, 0] > coefficients, 0.0, np.inf)


@inlined
def force(a, j, d):
    """Return k d."""
    return a[STIFFNESS, j] * d


@inlined
def energy(a, j, d):
    """Return k d^2 / 2."""
    return 0.5 * a[STIFFNESS, j] * (d * d)


@inlined
def force_slopes(a, j, d):
    """Return F, k while the grains touch, and d."""
    k = a[STIFFNESS, j]
    return k * d, k if d > 0.0 else 0.0, d


@inlined
def energy_pullback(a, adjoint, j, d, slope):
    """Add slope dE/dk."""
    adjoint[STIFFNESS, j] += 0.5 * (d * d) * slope


@inlined
def coefficient(a, j, d):
    """Return c."""
    return a[LAW_CONSTANTS, j]


@inlined
def coefficient_pullback(a, adjoint, j, d, slope):
    """Add slope to the derivative by c; the overlap does not matter."""
    adjoint[LAW_CONSTANTS, j] += slope
    return 0.0
