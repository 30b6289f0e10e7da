"""A general exponent, F = k d^p: p = 1 linear springs without tension, 1.5 spheres, 2 cones, others for other tips and shells.

V. F. Nesterenko, Dynamics of Heterogeneous Materials (Springer 2001), section 1.6: solitary waves exist for every p > 1, and
their width depends on p alone.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ...support.jit import internal_inlined
from ...support.parameter_fields import field
from ...support.powers import power
from ..layout import SMALLEST_OVERLAP
from . import functions
from .law import FloatArray, Law


class PowerContacts(NamedTuple):
    """Constants of the contacts: k [N/m^p] and p, the same for all contacts."""

    stiffness: FloatArray
    exponent: FloatArray


class Power(Law):
    """F = k d^exponent; k is the parameter `contact_stiffness` in N/m^exponent, which must be given."""

    contacts: ClassVar[type] = PowerContacts
    needs_stiffness: ClassVar[bool] = True

    name: Literal["power"] = field("power", "a general exponent", "1")
    exponent: float = field(  # pyright: ignore[reportIncompatibleVariableOverride]
        ..., "exponent p of F = k d^p", "1", ge=1.0, le=10.0
    )

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the exponent for each contact."""
        return np.full((contacts.stop - contacts.start, 1), self.exponent)

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return (F / k)^(1/p)."""
        ratio = force / stiffness
        return np.array([power(value, 1.0 / self.exponent) if value > SMALLEST_OVERLAP else 0.0 for value in ratio])


@functions.contact_law.register(PowerContacts)
def power_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses and the exponent, the first constant."""
    return PowerContacts(stiffness, constants[0])


@internal_inlined
def _positive_power(d, p):
    """Return d^p, or 0 for an open contact."""
    raised = power(d if d > SMALLEST_OVERLAP else SMALLEST_OVERLAP, p)
    return raised if d > SMALLEST_OVERLAP else 0.0 * d


@functions.force.register(PowerContacts)
def force(law, j, d):
    """Return F = k d^p."""
    return law.stiffness[j] * _positive_power(d, law.exponent[j])


@functions.energy.register(PowerContacts)
def energy(law, j, d):
    """Return E = k d^(p + 1) / (p + 1)."""
    p = law.exponent[j]
    return law.stiffness[j] * (d * _positive_power(d, p)) / (p + 1.0)


@functions.force_pullback.register(PowerContacts)
def force_pullback(law, adjoint, j, d, slope):
    """Add slope * d^p to the adjoint of k; return slope * p k d^(p - 1)."""
    k, p = law.stiffness[j], law.exponent[j]
    adjoint.stiffness[j] += _positive_power(d, p) * slope
    return k * (p * _positive_power(d, p - 1.0)) * slope


@functions.energy_pullback.register(PowerContacts)
def energy_pullback(law, adjoint, j, d, slope):
    """Add slope * (dE/dk) to the adjoint of k."""
    p = law.exponent[j]
    adjoint.stiffness[j] += (d * _positive_power(d, p)) / (p + 1.0) * slope
