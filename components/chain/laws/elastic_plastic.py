"""Elastic-perfectly plastic spheres: C. Thornton, J. Appl. Mech. 64 (1997) 383.

Loading follows Hertz up to the overlap d_y at which the pressure in the middle of the contact reaches the yield pressure p_y,
d_y = R* (pi p_y / 2E*)^2, and from there the tangent: F = F_y + pi p_y R* (d - d_y). Unloading from the deepest overlap D
follows Hertz for the flattened contact, whose radius is R* F_H(D) / F(D), F_H being Hertz's force: F = k_u (d - d_r)^1.5 with
k_u = k sqrt(F_H(D) / F(D)); reloading follows the same curve back to D.

A contact's history (k_u, d_r, D) changes once per completed step; inside a step the force is that of the history at its begin,
so each step is conservative and the loss is booked when the history changes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from math import sqrt
from types import MappingProxyType
from typing import ClassVar, Literal

import numpy as np

from ...errors import ParameterError
from ...support.elementary_functions import two_thirds_power
from ...support.jit import inlined, jit
from ...support.parameter_fields import NotNegative, Positive, field
from ..layout import DISSIPATED, LAW_CONSTANTS, SMALLEST_OVERLAP, STIFFNESS
from .hertz import hertz_energy, hertz_force
from .law import YIELD_PRESSURE, FloatArray, Law

# History: unloading stiffness, residual overlap and deepest overlap.
UNLOADING, RESIDUAL, DEEPEST = range(DISSIPATED - 3, DISSIPATED)


class ElasticPlastic(Law):
    """Hertz up to the yield pressure, its tangent beyond, unloading along the flattened spheres' own Hertz law."""

    exponent: ClassVar[float] = 1.5
    history_rows: ClassVar[int] = 3
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({"yield_pressure": True})

    name: Literal["elastic_plastic"] = field("elastic_plastic", "Thornton's elastic-perfectly plastic spheres", "1")
    yield_pressure: Positive | list[NotNegative] | None = field(
        None,
        "pressure at which a contact yields: one for all, or one for each place; default 1.6 times the softer yield strength",
        "Pa",
    )

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the root of the yield overlap, pi p_y R* / (1.5 k), which follows from d_y with k = (4/3) E* sqrt(R*)."""
        pressure = YIELD_PRESSURE * yield_strength if self.yield_pressure is None else np.asarray(self.yield_pressure)
        pressure = (np.zeros(len(stiffness)) + pressure)[contacts]
        if np.any(np.isnan(pressure)):
            where = contacts.start + int(np.argmax(np.isnan(pressure)))
            raise ParameterError(
                f"neither side of contact {where} has a yield_strength",
                hint="give yield_pressure, or materials that have one",
                at="law.yield_pressure",
            )
        return (math.pi * pressure * reduced_radius[contacts] / (1.5 * stiffness[contacts]))[:, None]

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return Hertz's, and along the tangent beyond the yield overlap."""
        root = constants[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            tangent = (force / (stiffness * root) + 0.5 * root * root) / 1.5
        yielding = force > stiffness * root * root * root
        return np.where(yielding, tangent, two_thirds_power(force / stiffness))

    def yield_pressures(self, stiffness: FloatArray, reduced_radius: FloatArray, constants: FloatArray) -> FloatArray:
        """Return p_y = 1.5 k sqrt(d_y) / (pi R*)."""
        return 1.5 / math.pi * stiffness * constants[:, 0] / reduced_radius


@inlined
def force(a, j, d):
    """Return the force on the unloading curve, or on the loading curve beyond the deepest overlap."""
    k, root, past = a[STIFFNESS, j], a[LAW_CONSTANTS, j], d - a[RESIDUAL, j]
    unloaded = hertz_force(a[UNLOADING, j], 0.0 if past < SMALLEST_OVERLAP else past)
    # The tangent of Hertz's law at the yield overlap.
    loading = k * root * (1.5 * d - 0.5 * root * root)
    return loading if d > a[DEEPEST, j] else unloaded


@inlined
def energy(a, j, d):
    """Return what the contact would give back, were it unloaded now."""
    past = (d if d < a[DEEPEST, j] else a[DEEPEST, j]) - a[RESIDUAL, j]
    return hertz_energy(a[UNLOADING, j], 0.0 if past < SMALLEST_OVERLAP else past)


@inlined
def begin(a, j):
    """Write the history of a contact that has never yielded."""
    a[UNLOADING, j], a[RESIDUAL, j] = a[STIFFNESS, j], 0.0
    # Where there is no contact nothing yields.
    a[DEEPEST, j] = a[LAW_CONSTANTS, j] * a[LAW_CONSTANTS, j] if a[STIFFNESS, j] > 0.0 else np.inf


@inlined
def remember(a, j, d):
    """Note a contact that is deeper than ever."""
    if d > a[DEEPEST, j]:
        _yield_further(a, j, d)


@jit
def _yield_further(a, j, d):
    """Load contact j to the overlap d, beyond its deepest."""
    k, root, before = a[STIFFNESS, j], a[LAW_CONSTANTS, j], a[DEEPEST, j]
    stored = energy(a, j, before)
    # The tangent's integral from the deepest overlap so far.
    work = k * root * ((0.75 * (d + before) - 0.5 * root * root) * (d - before))
    loaded = k * root * (1.5 * d - 0.5 * root * root)
    unloading = k * sqrt(k * (d * sqrt(d)) / loaded)
    # (F / k_u)^(2/3), which k_u = k sqrt(k d^1.5 / F) makes a quotient.
    elastic = loaded / (k * sqrt(d))
    a[DEEPEST, j], a[UNLOADING, j], a[RESIDUAL, j] = d, unloading, d - elastic
    a[DISSIPATED, j] += stored + work - hertz_energy(unloading, elastic)
