"""Elastic-perfectly plastic spheres: C. Thornton, J. Appl. Mech. 64 (1997) 383.

Loading follows Hertz up to the overlap d_y at which the pressure in the middle of the contact reaches the yield pressure p_y,
d_y = R* (pi p_y / 2E*)^2, and then the tangent: F = F_y + pi p_y R* (d - d_y). Unloading from the deepest overlap D
follows Hertz for the flattened contact of radius R* F_H(D) / F(D), with Hertz's force F_H: F = k_u (d - d_r)^1.5 with
k_u = k sqrt(F_H(D) / F(D)). Reloading follows the same curve back to D.

A contact's history (k_u, d_r, D) is updated once per completed step. Within a step the force uses the history at its beginning,
so each step is conservative, and the dissipation is tallied when the history is updated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from math import sqrt
from types import MappingProxyType
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ...errors import ParameterError
from ...support.elementary_functions import two_thirds_power
from ...support.parameter_fields import NotNegative, Positive, field
from ..layout import SMALLEST_OVERLAP
from . import functions
from .hertz import hertz_energy, hertz_force
from .law import YIELD_PRESSURE, FloatArray, Law


class ElasticPlasticContacts(NamedTuple):
    """Constants and history of the contacts.

    Attributes:
        stiffness: k of Hertz's law [N/m^1.5].
        yield_root: square root of the overlap at yield [m^0.5].
        unloading: k_u [N/m^1.5].
        residual: d_r [m].
        deepest: D [m].
    """

    stiffness: FloatArray
    yield_root: FloatArray
    unloading: FloatArray
    residual: FloatArray
    deepest: FloatArray


class ElasticPlastic(Law):
    """Hertz up to the yield pressure, its tangent beyond; unloading by Hertz's law of the flattened spheres."""

    contacts: ClassVar[type] = ElasticPlasticContacts
    exponent: ClassVar[float] = 1.5
    history_rows: ClassVar[int] = 3
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({"yield_pressure": True})

    name: Literal["elastic_plastic"] = field("elastic_plastic", "Thornton's elastic-perfectly plastic spheres", "1")
    yield_pressure: Positive | list[NotNegative] | None = field(
        None,
        "pressure at which a contact yields: one for all, or one for each place; default: 1.6 times the lower yield strength",
        "Pa",
    )

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the square root of the yield overlap, pi p_y R* / (1.5 k); it follows from d_y with k = (4/3) E* sqrt(R*)."""
        pressure = YIELD_PRESSURE * yield_strength if self.yield_pressure is None else np.asarray(self.yield_pressure)
        pressure = (np.zeros(len(stiffness)) + pressure)[contacts]
        if np.any(np.isnan(pressure)):
            where = contacts.start + int(np.argmax(np.isnan(pressure)))
            raise ParameterError(
                f"neither side of contact {where} has a yield_strength",
                hint="give yield_pressure, or materials with a yield_strength",
                at="law.yield_pressure",
            )
        return (math.pi * pressure * reduced_radius[contacts] / (1.5 * stiffness[contacts]))[:, None]

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return the overlap at a force: by Hertz's law, or by its tangent beyond the yield overlap."""
        root = constants[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            tangent = (force / (stiffness * root) + 0.5 * root * root) / 1.5
        yielding = force > stiffness * root * root * root
        return np.where(yielding, tangent, two_thirds_power(force / stiffness))

    def yield_pressures(self, stiffness: FloatArray, reduced_radius: FloatArray, constants: FloatArray) -> FloatArray:
        """Return p_y = 1.5 k sqrt(d_y) / (pi R*)."""
        return 1.5 / math.pi * stiffness * constants[:, 0] / reduced_radius


@functions.contact_law.register(ElasticPlasticContacts)
def elastic_plastic_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses, constants and histories."""
    return ElasticPlasticContacts(stiffness, constants[0], history[0], history[1], history[2])


@functions.force.register(ElasticPlasticContacts)
def force(law, j, d):
    """Return the force on the unloading curve, or on the loading curve beyond the deepest overlap."""
    past, root = d - law.residual[j], law.yield_root[j]
    unloaded = hertz_force(law.unloading[j], 0.0 if past < SMALLEST_OVERLAP else past)
    # The tangent of Hertz's law at the yield overlap.
    loading = law.stiffness[j] * root * (1.5 * d - 0.5 * root * root)
    return loading if d > law.deepest[j] else unloaded


@functions.energy.register(ElasticPlasticContacts)
def energy(law, j, d):
    """Return the energy that the contact would release on unloading."""
    past = (d if d < law.deepest[j] else law.deepest[j]) - law.residual[j]
    return hertz_energy(law.unloading[j], 0.0 if past < SMALLEST_OVERLAP else past)


@functions.has_history.register(ElasticPlasticContacts)
def has_history(law):
    """Return True: the force depends on the deepest overlap so far."""
    return True


@functions.begin_history.register(ElasticPlasticContacts)
def begin_history(law, j):
    """Write the history of a contact that has never yielded."""
    law.unloading[j], law.residual[j] = law.stiffness[j], 0.0
    # Places without a contact do not yield.
    law.deepest[j] = law.yield_root[j] * law.yield_root[j] if law.stiffness[j] > 0.0 else np.inf


@functions.update_history.register(ElasticPlasticContacts)
def update_history(law, j, d):
    """Load contact j to the overlap d if this exceeds its deepest overlap; return the dissipated energy."""
    k, root, before = law.stiffness[j], law.yield_root[j], law.deepest[j]
    if not d > before:
        return 0.0
    past = before - law.residual[j]
    stored = hertz_energy(law.unloading[j], 0.0 if past < SMALLEST_OVERLAP else past)
    # Work of the tangent force from the previous deepest overlap to d.
    work = k * root * ((0.75 * (d + before) - 0.5 * root * root) * (d - before))
    loaded = k * root * (1.5 * d - 0.5 * root * root)
    unloading = k * sqrt(k * (d * sqrt(d)) / loaded)
    # d - d_r = (F / k_u)^(2/3); with k_u = k sqrt(k d^1.5 / F) this is a quotient, without a power function.
    elastic = loaded / (k * sqrt(d))
    law.deepest[j], law.unloading[j], law.residual[j] = d, unloading, d - elastic
    return stored + work - hertz_energy(unloading, elastic)
