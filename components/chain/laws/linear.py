"""A linear spring and dashpot: F = k d + c dd/dt while the grains touch, never attractive.

P. A. Cundall, O. D. L. Strack, Geotechnique 29 (1979) 47; the contact of most discrete element codes. With
zeta = c / (2 sqrt(k m*)), m* the reduced mass, a contact with attraction has the restitution exp(-pi zeta / sqrt(1 - zeta^2))
at any speed; a contact that opens at zero force has more: T. Schwager, T. Poeschel, Granular Matter 9 (2007) 465, eq. (10).
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ...support.parameter_fields import NotNegative, field
from . import functions
from .law import Dissipative, FloatArray


class LinearContacts(NamedTuple):
    """Constants of the contacts: k [N/m] and c [N s/m]."""

    stiffness: FloatArray
    dissipation: FloatArray


class Dashpot(Dissipative):
    """A law whose dissipation is a constant force per approach speed while the grains touch."""

    has_force_jump: ClassVar[bool] = True

    def damping_coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return c, which does not depend on the overlap."""
        return constants[:, 0]

    def overlap_from_coefficient(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return 0 where c exceeds the coefficient (at every overlap), infinity where it does not."""
        return np.where(constants[:, 0] > coefficients, 0.0, np.inf)


class Linear(Dashpot):
    """F = k d + dissipation x dd/dt while d > 0, cut off at 0; k is the parameter `contact_stiffness`, in N/m."""

    contacts: ClassVar[type] = LinearContacts
    exponent: ClassVar[float] = 1.0
    needs_stiffness: ClassVar[bool] = True

    name: Literal["linear"] = field("linear", "a linear spring and dashpot", "1")
    dissipation: NotNegative | list[NotNegative] = field(0.0, "coefficient c: one for all contacts or one per place", "N s/m")

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return F / k."""
        return force / stiffness


@functions.contact_law.register(LinearContacts)
def linear_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses k and dashpot constants c."""
    return LinearContacts(stiffness, constants[0])


@functions.force.register(LinearContacts)
def force(law, j, d):
    """Return the elastic force k d."""
    return law.stiffness[j] * d


@functions.energy.register(LinearContacts)
def energy(law, j, d):
    """Return k d^2 / 2."""
    return 0.5 * law.stiffness[j] * (d * d)


@functions.damping.register(LinearContacts)
def damping(law, j, d):
    """Return c, the dissipative force per approach speed."""
    return law.dissipation[j]


@functions.has_force_jump.register(LinearContacts)
def has_force_jump(law):
    """Return True: a contact closes at a finite speed, at which the dashpot force begins at once."""
    return True


@functions.force_pullback.register(LinearContacts)
def force_pullback(law, adjoint, j, d, slope):
    """Add slope * d to the adjoint of k; return slope * k while the grains touch, else 0."""
    adjoint.stiffness[j] += d * slope
    return (law.stiffness[j] if d > 0.0 else 0.0) * slope


@functions.energy_pullback.register(LinearContacts)
def energy_pullback(law, adjoint, j, d, slope):
    """Add slope * (dE/dk) to the adjoint of k."""
    adjoint.stiffness[j] += 0.5 * (d * d) * slope


@functions.damping_pullback.register(LinearContacts)
def damping_pullback(law, adjoint, j, d, slope):
    """Add slope to the adjoint of c; return 0, because the overlap has no effect."""
    adjoint.dissipation[j] += slope
    return 0.0
