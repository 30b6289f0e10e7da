"""Hertz with a dashpot: F = k d^1.5 + c dd/dt while the spheres touch, never attractive.

The simplest form of dissipation, and the wrong one for spheres: the loss increases at low speed, 1 - e ~ v^(-1/5). P. A.
Cundall, O. D. L. Strack, Geotechnique 29 (1979) 47, with Hertz's spring instead of their linear one.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from ...support.parameter_fields import NotNegative, field
from . import functions, linear
from .hertz import HertzRest, register_hertz_spring
from .law import FloatArray


class ViscousContacts(NamedTuple):
    """Constants of the contacts: k [N/m^1.5] and c [N s/m]."""

    stiffness: FloatArray
    dissipation: FloatArray


class Viscous(HertzRest, linear.Dashpot):
    """F = k d^1.5 + dissipation x dd/dt while d > 0, cut off at 0."""

    contacts: ClassVar[type] = ViscousContacts

    name: Literal["viscous"] = field("viscous", "Hertz with a dashpot", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "coefficient c: one for all contacts or one per place", "N s/m")


@functions.contact_law.register(ViscousContacts)
def viscous_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses k and dashpot constants c."""
    return ViscousContacts(stiffness, constants[0])


register_hertz_spring(ViscousContacts)
# The functions of the dashpot are those of the linear law.
functions.damping.register(ViscousContacts)(linear.damping)
functions.has_force_jump.register(ViscousContacts)(linear.has_force_jump)
functions.damping_pullback.register(ViscousContacts)(linear.damping_pullback)
