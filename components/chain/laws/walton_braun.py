"""Walton and Braun (1986): a linear spring that unloads along a steeper line, F = k1 d in loading, k2 (d - d_r) in unloading.

O. R. Walton, R. L. Braun, J. Rheol. 30 (1986) 949, with constant k1 and k2. Unloading from the deepest overlap D ends at the
residual overlap d_r = D (1 - k1/k2); reloading follows the same line back to D. A collision has the restitution sqrt(k1/k2) at
any speed.

A contact's history, D, is updated once per completed step. Within a step the force uses the history at its beginning, so each
step is conservative, and the dissipation is tallied when the history is updated.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ...errors import ParameterError
from ...support.parameter_fields import NotNegative, Positive, field
from . import functions
from .law import FloatArray, Law


class WaltonBraunContacts(NamedTuple):
    """Constants and history of the contacts.

    Attributes:
        stiffness: k1 [N/m].
        unloading: k2 [N/m].
        residual_part: 1 - k1/k2, the fraction of the deepest overlap that remains.
        deepest: D [m].
    """

    stiffness: FloatArray
    unloading: FloatArray
    residual_part: FloatArray
    deepest: FloatArray


class WaltonBraun(Law):
    """k1 d in loading, where k1 is `contact_stiffness` in N/m, and the stiffness k2 in unloading."""

    contacts: ClassVar[type] = WaltonBraunContacts
    exponent: ClassVar[float] = 1.0
    history_rows: ClassVar[int] = 1
    needs_stiffness: ClassVar[bool] = True
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({"unloading_stiffness": True})

    name: Literal["walton_braun"] = field("walton_braun", "linear, with a stiffer unloading", "1")
    unloading_stiffness: Positive | list[NotNegative] = field(
        ..., "unloading stiffness k2, at least contact_stiffness: one for all contacts, or one for each place", "N/m"
    )

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return k2 and 1 - k1/k2 for each contact."""
        loading = stiffness[contacts]
        unloading = (np.zeros(len(stiffness)) + np.asarray(self.unloading_stiffness))[contacts]
        soft = unloading < loading
        if soft.any():
            where = int(np.argmax(soft))
            raise ParameterError(
                f"got {unloading[where]:g} N/m for contact {contacts.start + where}",
                expected=f"at least its contact_stiffness, {loading[where]:g} N/m: unloading must not be softer than loading",
                at="law.unloading_stiffness",
            )
        return np.column_stack([unloading, 1.0 - loading / unloading])

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return F / k1."""
        return force / stiffness

    def largest_stiffness(self, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return k2, the stiffness in unloading."""
        return constants[:, 0]


@functions.contact_law.register(WaltonBraunContacts)
def walton_braun_contacts(kind, stiffness, constants, history):
    """Return the law with these stiffnesses, constants and histories."""
    return WaltonBraunContacts(stiffness, constants[0], constants[1], history[2])


@functions.force.register(WaltonBraunContacts)
def force(law, j, d):
    """Return the force on the unloading line, or on the loading line beyond the deepest overlap."""
    past = d - law.residual_part[j] * law.deepest[j]
    unloaded = law.unloading[j] * (past if past > 0.0 else 0.0)
    loading = law.stiffness[j] * d
    return loading if d > law.deepest[j] else unloaded


@functions.energy.register(WaltonBraunContacts)
def energy(law, j, d):
    """Return the energy that the contact would release on unloading."""
    past = (d if d < law.deepest[j] else law.deepest[j]) - law.residual_part[j] * law.deepest[j]
    past = past if past > 0.0 else 0.0
    return 0.5 * law.unloading[j] * (past * past)


@functions.has_history.register(WaltonBraunContacts)
def has_history(law):
    """Return True: the force depends on the deepest overlap so far."""
    return True


@functions.begin_history.register(WaltonBraunContacts)
def begin_history(law, j):
    """Write the history of a contact that has never been loaded."""
    law.deepest[j] = 0.0


@functions.update_history.register(WaltonBraunContacts)
def update_history(law, j, d):
    """Record a new deepest overlap; return the loss from the old to the new one, the integral of k1 (1 - k1/k2) d."""
    deepest = law.deepest[j]
    if not d > deepest:
        return 0.0
    law.deepest[j] = d
    return 0.5 * (law.stiffness[j] * law.residual_part[j]) * ((d - deepest) * (d + deepest))
