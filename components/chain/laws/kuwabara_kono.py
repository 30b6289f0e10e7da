"""Kuwabara and Kono (1987): viscoelastic spheres, F = k d^1.5 + gamma sqrt(d) dd/dt, and never a pull.

G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26 (1987) 1230; N. V. Brilliantov, F. Spahn, J.-M. Hertzsch, T. Poeschel, Phys. Rev. E
53 (1996) 5382. The loss in a collision grows with speed, 1 - e ~ v^(1/5).
"""

from __future__ import annotations

from math import sqrt
from typing import ClassVar, Literal

import numpy as np

from ...support.jit import inlined
from ..fields import NotNegative, field
from ..layout import HERTZ, KUWABARA_KONO, SMALLEST_OVERLAP
from .law import Dissipative, FloatArray


class KuwabaraKono(Dissipative):
    """F = k d^1.5 + dissipation x sqrt(d) dd/dt while d > 0, cut off at 0."""

    exponent: ClassVar[float] = 1.5
    elastic, damping = HERTZ, KUWABARA_KONO

    name: Literal["kuwabara_kono"] = field("kuwabara_kono", "viscoelastic spheres", "1")
    dissipation: NotNegative | list[NotNegative] = field(..., "gamma: one for all contacts, or one for each place", "N s/m^1.5")

    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Gamma sqrt(d)."""
        return constants * np.sqrt(overlap)

    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """(coefficient / gamma)^2."""
        with np.errstate(divide="ignore", over="ignore"):
            root = coefficients / constants
            return root * root


@inlined
def coefficient(gamma, d):
    """Force per speed of approach: gamma sqrt(d) while they touch."""
    d = 0.0 if d < SMALLEST_OVERLAP else d
    return gamma * sqrt(d)
