"""Kuwabara and Kono (1987): viscoelastic spheres, F = k d^1.5 + gamma sqrt(d) dd/dt, never attractive.

G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26 (1987) 1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poeschel, Phys. Rev. E
53 (1996) 5382. The loss in a collision grows with speed, 1 - e ~ v^(1/5).
"""

from __future__ import annotations

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ...support.parameter_fields import NotNegative, field
from . import functions
from .hertz import HertzRest, register_hertz_spring
from .law import Dissipative, FloatArray


class KuwabaraKonoContacts(NamedTuple):
    """Constants of the contacts: k [N/m^1.5] and gamma [N s/m^1.5]."""

    stiffness: FloatArray
    dissipation: FloatArray


class KuwabaraKono(HertzRest, Dissipative):
    """F = k d^1.5 + dissipation x sqrt(d) dd/dt while d > 0, cut off at 0."""

    contacts: ClassVar[type] = KuwabaraKonoContacts

    name: Literal["kuwabara_kono"] = field("kuwabara_kono", "viscoelastic spheres", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "coefficient gamma: one for all or one per place", "N s/m^1.5")

    def damping_coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return gamma sqrt(d), the dissipative force per approach speed."""
        return constants[:, 0] * np.sqrt(overlap)

    def overlap_from_coefficient(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return the overlap (coefficient / gamma)^2 at which gamma sqrt(d) equals the coefficient."""
        with np.errstate(divide="ignore", over="ignore"):
            root = coefficients / constants[:, 0]
            return root * root


@functions.contact_law.register(KuwabaraKonoContacts)
def kuwabara_kono_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses and gamma, the first constant."""
    return KuwabaraKonoContacts(stiffness, constants[0])


@functions.damping.register(KuwabaraKonoContacts)
def damping(law, j, d):
    """Return gamma sqrt(d)."""
    return law.dissipation[j] * sqrt(d)


@functions.damping_pullback.register(KuwabaraKonoContacts)
def damping_pullback(law, adjoint, j, d, slope):
    """Add slope * sqrt(d) to the adjoint of gamma; return slope * gamma / (2 sqrt(d))."""
    root = sqrt(d)
    adjoint.dissipation[j] += slope * root
    return 0.5 * law.dissipation[j] / root * slope if d > 0.0 else 0.0


register_hertz_spring(KuwabaraKonoContacts)
