"""A general exponent, F = k d^p: p = 1 linear springs without tension, 1.5 spheres, 2 cones, others for other tips and shells.

V. F. Nesterenko, Dynamics of Heterogeneous Materials (Springer 2001), section 1.6: solitary waves exist for every p > 1, and
their width depends on p alone.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from ...support.jit import inlined
from ...support.parameter_fields import field
from ...support.powers import power
from ..layout import EXPONENT, SCALARS, SMALLEST_OVERLAP, STIFFNESS
from .law import FloatArray, Law


class Power(Law):
    """F = k d^exponent, k the parameter `contact_stiffness` in N/m^exponent, which has to be given."""

    needs_stiffness: ClassVar[bool] = True
    long_formula: ClassVar[bool] = True

    name: Literal["power"] = field("power", "a general exponent", "1")
    exponent: float = field(  # pyright: ignore[reportIncompatibleVariableOverride]
        ..., "p of F = k d^p", "1", ge=1.0, le=10.0
    )

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return (F / k)^(1/p)."""
        ratio = force / stiffness
        return np.array([power(value, 1.0 / self.exponent) if value > SMALLEST_OVERLAP else 0.0 for value in ratio])


@inlined
def _open_power(d, p):
    """Return d^p, 0 where the contact is open."""
    raised = power(d if d > SMALLEST_OVERLAP else SMALLEST_OVERLAP, p)
    return raised if d > SMALLEST_OVERLAP else 0.0 * d


@inlined
def force(a, j, d):
    """Return F = k d^p."""
    return a[STIFFNESS, j] * _open_power(d, a[SCALARS, EXPONENT])


@inlined
def energy(a, j, d):
    """Return E = k d^(p + 1) / (p + 1)."""
    p = a[SCALARS, EXPONENT]
    return a[STIFFNESS, j] * (d * _open_power(d, p)) / (p + 1.0)


@inlined
def force_slopes(a, j, d):
    """Return F, p k d^(p - 1) and d^p."""
    k, p = a[STIFFNESS, j], a[SCALARS, EXPONENT]
    raised = _open_power(d, p)
    return k * raised, k * (p * _open_power(d, p - 1.0)), raised


@inlined
def energy_pullback(a, adjoint, j, d, slope):
    """Add slope dE/dk."""
    p = a[SCALARS, EXPONENT]
    adjoint[STIFFNESS, j] += (d * _open_power(d, p)) / (p + 1.0) * slope
