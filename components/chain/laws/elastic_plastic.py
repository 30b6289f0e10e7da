"""Elastic-perfectly plastic spheres: C. Thornton, J. Appl. Mech. 64 (1997) 383.

Loading follows Hertz up to the overlap d_y at which the pressure in the middle of the contact reaches the yield pressure p_y,
d_y = R* (pi p_y / 2E*)^2, and from there the tangent: F = F_y + pi p_y R* (d - d_y). Unloading from the deepest overlap D
follows Hertz for the flattened contact, whose radius is R* F_H(D) / F(D), F_H being Hertz's force: F = k_u (d - d_r)^1.5 with
k_u = k sqrt(F_H(D) / F(D)); reloading follows the same curve back to D.

A contact's history (D, k_u, d_r) changes once per completed step; inside a step the force is that of the history at its begin,
so each step is conservative and the loss is booked when the history changes.
"""

from __future__ import annotations

import math
from math import sqrt
from typing import ClassVar, Literal

import numpy as np

from ...errors import ParameterError
from ...support.jit import inlined, jit
from ...support.roots import two_thirds_power
from ..fields import NotNegative, Positive, field
from ..layout import CONTACT, DEEPEST, DISSIPATED, GRAINS, PLASTIC, RESIDUAL, REST_OVERLAP, SCALARS, STIFFNESS, UNLOADING
from . import hertz
from .law import FloatArray, Law

# A sphere begins to yield, under its surface, at a peak pressure of 1.6 times the yield strength (Johnson 1985, section 6.1).
YIELD_PRESSURE = 1.6

_ONE = np.uint64(1)


class ElasticPlastic(Law):
    """Hertz up to the yield pressure, its tangent beyond, unloading along the flattened spheres' own Hertz law."""

    exponent: ClassVar[float] = 1.5
    elastic = PLASTIC
    has_history = True

    name: Literal["elastic_plastic"] = field("elastic_plastic", "Thornton's elastic-perfectly plastic spheres", "1")
    yield_pressure: Positive | list[NotNegative] | None = field(
        None,
        "pressure at which a contact yields: one for all, or one for each place; default 1.6 times the softer yield strength",
        "Pa",
    )

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, real: slice
    ) -> FloatArray:
        """The root of the yield overlap, pi p_y R* / (1.5 k), which follows from d_y with k = (4/3) E* sqrt(R*)."""
        pressure = YIELD_PRESSURE * yield_strength if self.yield_pressure is None else np.asarray(self.yield_pressure)
        pressure = (np.zeros(len(stiffness)) + pressure)[real]
        if np.any(np.isnan(pressure)):
            where = real.start + int(np.argmax(np.isnan(pressure)))
            raise ParameterError(
                f"law.yield_pressure: neither side of contact {where} has a yield_strength; give yield_pressure, or materials "
                "that have one"
            )
        return math.pi * pressure * reduced_radius[real] / (1.5 * stiffness[real])

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Hertz's, and along the tangent beyond the yield overlap."""
        with np.errstate(divide="ignore", invalid="ignore"):
            tangent = (force / (stiffness * constants) + 0.5 * constants * constants) / 1.5
        yielding = force > stiffness * constants * constants * constants
        return np.where(yielding, tangent, two_thirds_power(force / stiffness))


@inlined
def force(k, d, root, deepest, unloading, residual):
    """Contact force; `root` is the square root of the yield overlap."""
    unloaded = hertz.force(unloading, d - residual)
    # The tangent of Hertz's law at the yield overlap.
    loading = k * root * (1.5 * d - 0.5 * root * root)
    return loading if d > deepest else unloaded


@inlined
def energy(k, d, root, deepest, unloading, residual):
    """What the contact would give back, were it unloaded now."""
    return hertz.energy(unloading, (d if d < deepest else deepest) - residual)


@jit
def begin(a):
    """The history of contacts that have never yielded."""
    for j in range(int(a[SCALARS, GRAINS]) + 1):
        a[UNLOADING, j], a[RESIDUAL, j], a[DISSIPATED, j] = a[STIFFNESS, j], 0.0, 0.0
        # Where there is no contact nothing yields.
        a[DEEPEST, j] = a[CONTACT, j] * a[CONTACT, j] if a[STIFFNESS, j] > 0.0 else np.inf


@jit
def remember(a, u):
    """Note contacts that are deeper than ever, and what the yielding since the last step has cost; displacements in row u."""
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        d = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j]
        if d > a[DEEPEST, j]:
            yielded(a, j, d)


@jit
def yielded(a, j, d):
    """Contact j has been loaded to the overlap d, beyond its deepest."""
    k, root, before = a[STIFFNESS, j], a[CONTACT, j], a[DEEPEST, j]
    stored = hertz.energy(a[UNLOADING, j], before - a[RESIDUAL, j])
    # The tangent's integral from the deepest overlap so far.
    work = k * root * ((0.75 * (d + before) - 0.5 * root * root) * (d - before))
    loaded = k * root * (1.5 * d - 0.5 * root * root)
    unloading = k * sqrt(k * (d * sqrt(d)) / loaded)
    # (F / k_u)^(2/3), which k_u = k sqrt(k d^1.5 / F) makes a quotient.
    elastic = loaded / (k * sqrt(d))
    a[DEEPEST, j], a[UNLOADING, j], a[RESIDUAL, j] = d, unloading, d - elastic
    a[DISSIPATED, j] += stored + work - hertz.energy(unloading, elastic)
