"""From the kind of a law to its functions, for the kernels. Where the kind is a constant, only its own branch is compiled."""

from __future__ import annotations

from ...support.jit import inlined
from ..layout import (
    CONTACT,
    DEEPEST,
    EXPONENT,
    HERTZ,
    POWER,
    RESIDUAL,
    SCALARS,
    STIFFNESS,
    UNLOADING,
    VISCOUS,
)
from . import elastic_plastic, hertz, kuwabara_kono, power, viscous


@inlined
def force(kind, a, j, d):
    """Elastic force of contact j at the overlap d."""
    if kind == HERTZ:
        return hertz.force(a[STIFFNESS, j], d)
    if kind == POWER:
        return power.force(a[STIFFNESS, j], d, a[SCALARS, EXPONENT])
    return elastic_plastic.force(a[STIFFNESS, j], d, a[CONTACT, j], a[DEEPEST, j], a[UNLOADING, j], a[RESIDUAL, j])


@inlined
def energy(kind, a, j, d):
    """Energy stored in contact j at the overlap d."""
    if kind == HERTZ:
        return hertz.energy(a[STIFFNESS, j], d)
    if kind == POWER:
        return power.energy(a[STIFFNESS, j], d, a[SCALARS, EXPONENT])
    return elastic_plastic.energy(a[STIFFNESS, j], d, a[CONTACT, j], a[DEEPEST, j], a[UNLOADING, j], a[RESIDUAL, j])


@inlined
def coefficient(kind, a, j, d):
    """Dissipative force of contact j at the overlap d per speed of approach."""
    if kind == VISCOUS:
        return viscous.coefficient(a[CONTACT, j], d)
    return kuwabara_kono.coefficient(a[CONTACT, j], d)
