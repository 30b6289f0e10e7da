"""Hertz (1882): two elastic spheres, F = k d^1.5 for an overlap d > 0. Equation (1.1) of Nesterenko (1983).

K. L. Johnson, Contact Mechanics (Cambridge 1985), section 4.2.
"""

from __future__ import annotations

from math import sqrt
from typing import ClassVar, Literal

from ...support.jit import inlined
from ..fields import field
from ..layout import HERTZ, SMALLEST_OVERLAP
from .law import Law


class Hertz(Law):
    """F = k d^1.5: elastic spheres. k follows from radii and materials, unless `contact_stiffness` is given."""

    exponent: ClassVar[float] = 1.5
    elastic = HERTZ

    name: Literal["hertz"] = field("hertz", "Hertz's law", "1")


@inlined
def force(k, d):
    """F = k d^1.5 for d > 0, else 0: no tension. NaN stays NaN."""
    return pressed_force(k, 0.0 if d < SMALLEST_OVERLAP else d)


@inlined
def pressed_force(k, d):
    """The same where d is 0 or large enough already: a second look at it costs a long loop dear."""
    return k * (d * sqrt(d))


@inlined
def energy(k, d):
    """Its work up to the overlap d: .4 k d^2.5."""
    d = 0.0 if d < SMALLEST_OVERLAP else d
    return 0.4 * k * (d * d * sqrt(d))
