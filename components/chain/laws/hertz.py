"""Hertz (1882): two elastic spheres, F = k d^1.5 for an overlap d > 0. Equation (1.1) of Nesterenko (1983).

K. L. Johnson, Contact Mechanics (Cambridge 1985), section 4.2.

The root of the energy: with s = sqrt(d) and s0 = sqrt(d0), d0 the overlap at rest, the energy above the rest state is
e = k (s - s0)^2 Q, Q = 0.4 s^3 + 0.8 s^2 s0 + 1.2 s s0^2 + 0.6 s0^3; no large numbers are subtracted at any precompression.
Without precompression sqrt(e) = sqrt(0.4 k) d^1.25.
"""

from __future__ import annotations

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

from ...support.elementary_functions import two_thirds_power
from ...support.jit import internal_inlined
from ...support.parameter_fields import field
from ..layout import SMALLEST_OVERLAP
from . import functions
from .law import FloatArray, Law


class HertzContacts(NamedTuple):
    """Constants of the contacts: k of F = k d^1.5 [N/m^1.5]."""

    stiffness: FloatArray


class HertzRest:
    """Exponent and static overlap of contacts with a Hertzian spring."""

    exponent: ClassVar[float] = 1.5

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return (F / k)^(2/3)."""
        return two_thirds_power(force / stiffness)


class Hertz(HertzRest, Law):
    """F = k d^1.5: elastic spheres. k follows from radii and materials, unless `contact_stiffness` is given."""

    contacts: ClassVar[type] = HertzContacts

    name: Literal["hertz"] = field("hertz", "Hertz's law", "1")


@functions.contact_law.register(HertzContacts)
def hertz_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses; it needs no other constants."""
    return HertzContacts(stiffness)


@internal_inlined
def hertz_force(k, d):
    """Return k d^1.5."""
    return k * (d * sqrt(d))


@internal_inlined
def hertz_energy(k, d):
    """Return the work of the force up to the overlap d, 0.4 k d^2.5."""
    return 0.4 * k * (d * d * sqrt(d))


def force(law, j, d):
    """Return F = k d^1.5."""
    return hertz_force(law.stiffness[j], d)


def energy(law, j, d):
    """Return E = 0.4 k d^2.5."""
    return hertz_energy(law.stiffness[j], d)


def force_pullback(law, adjoint, j, d, slope):
    """Add slope * d^1.5 to the adjoint of k; return slope * 1.5 k d^0.5."""
    root = sqrt(d)
    adjoint.stiffness[j] += d * root * slope
    return law.stiffness[j] * (1.5 * root) * slope


def energy_pullback(law, adjoint, j, d, slope):
    """Add slope * (dE/dk) to the adjoint of k."""
    adjoint.stiffness[j] += (0.4 * (d * d * sqrt(d))) * slope


@internal_inlined
def _overlap_roots(d, rest):
    """Return sqrt(d), 0 for an open contact, and sqrt(d0), 0 for a gap at rest (d0 < 0)."""
    return sqrt(d) if d > SMALLEST_OVERLAP else 0.0, sqrt(max(rest, 0.0))


@internal_inlined
def _energy_quotient(s, s0):
    """Return the factor Q of the energy above rest, e = k (s - s0)^2 Q."""
    return s * s * (0.4 * s + 0.8 * s0) + s0 * s0 * (1.2 * s + 0.6 * s0)


def energy_root(law, j, d, rest):
    """Return the root q = sqrt(k Q) (s - s0) of the energy above rest."""
    s, s0 = _overlap_roots(d, rest)
    return sqrt(law.stiffness[j] * _energy_quotient(s, s0)) * (s - s0)


def energy_root_pullback(law, adjoint, j, d, rest, slope):
    """Add slope * (dq/dk) to the adjoint of k; return slope * (dq/dd) and slope * (dq/d(overlap at rest))."""
    s, s0 = _overlap_roots(d, rest)
    quotient = _energy_quotient(s, s0)
    if quotient <= 0.0 or law.stiffness[j] <= 0.0:
        return 0.0, 0.0
    root = sqrt(law.stiffness[j] / quotient)
    adjoint.stiffness[j] += slope * 0.5 * root * quotient * (s - s0) / law.stiffness[j]
    along = slope * 0.5 * root * (s * s + s * s0 + s0 * s0) if s > 0.0 else 0.0
    # A larger overlap at rest increases the whole overlap, and shifts the reference of the energy.
    return along, -slope * 0.75 * root * s0 * (s + s0)


def register_hertz_spring(kind: type) -> None:
    """Register the elastic functions of Hertz's law for a law whose class has a field `stiffness`."""
    for function, implementation in (
        (functions.force, force),
        (functions.energy, energy),
        (functions.force_pullback, force_pullback),
        (functions.energy_pullback, energy_pullback),
        (functions.energy_root, energy_root),
        (functions.energy_root_pullback, energy_root_pullback),
    ):
        function.register(kind)(implementation)


register_hertz_spring(HertzContacts)
