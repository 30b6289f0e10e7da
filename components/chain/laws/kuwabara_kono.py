"""Kuwabara and Kono (1987): viscoelastic spheres, F = k d^1.5 + gamma sqrt(d) dd/dt, and never a pull.

G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26 (1987) 1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poeschel, Phys. Rev. E
53 (1996) 5382. The loss in a collision grows with speed, 1 - e ~ v^(1/5).
"""

from __future__ import annotations

from math import sqrt
from typing import Literal

import numpy as np

from ...support.jit import inlined
from ...support.parameter_fields import NotNegative, field
from ..layout import LAW_CONSTANTS
from .hertz import HertzRest, energy, energy_pullback, energy_root, energy_root_pullback, force, force_slopes
from .law import Dissipative, FloatArray

__all__ = [
    "KuwabaraKono", "coefficient", "coefficient_pullback", "energy", "energy_pullback", "energy_root", "energy_root_pullback",
    "force", "force_slopes",
]  # fmt: skip


class KuwabaraKono(HertzRest, Dissipative):
    """F = k d^1.5 + dissipation x sqrt(d) dd/dt while d > 0, cut off at 0."""

    name: Literal["kuwabara_kono"] = field("kuwabara_kono", "viscoelastic spheres", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "gamma: one for all contacts, or one for each place", "N s/m^1.5")

    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return gamma sqrt(d)."""
        return constants[:, 0] * np.sqrt(overlap)

    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return (coefficient / gamma)^2."""
        with np.errstate(divide="ignore", over="ignore"):
            root = coefficients / constants[:, 0]
            return root * root


@inlined
def coefficient(a, j, d):
    """Return gamma sqrt(d)."""
    return a[LAW_CONSTANTS, j] * sqrt(d)


@inlined
def coefficient_pullback(a, adjoint, j, d, slope):
    """Add slope sqrt(d) to the derivative by gamma; return slope gamma / (2 sqrt(d))."""
    root = sqrt(d)
    adjoint[LAW_CONSTANTS, j] += slope * root
    return 0.5 * a[LAW_CONSTANTS, j] / root * slope if d > 0.0 else 0.0
