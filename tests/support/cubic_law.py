"""A contact law outside the package, F = k d + k3 d^3, whose static overlap is not (F / k)^(1 / p)."""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from granular_env.components.chain.laws import functions
from granular_env.components.chain.laws.law import Law


class CubicContacts(NamedTuple):
    """Constants of the contacts: k [N/m] and k3 [N/m^3]."""

    stiffness: np.ndarray
    hardening: np.ndarray


class Cubic(Law):
    """F = k d + hardening d^3 while d > 0."""

    contacts: ClassVar[type] = CubicContacts
    exponent: ClassVar[float] = 1.0
    needs_stiffness: ClassVar[bool] = True

    name: Literal["cubic"] = "cubic"
    hardening: float = 1e17

    def contact_constants(
        self, stiffness: np.ndarray, reduced_radius: np.ndarray, yield_strength: np.ndarray, contacts: slice
    ) -> np.ndarray:
        """Return k3."""
        return np.full((contacts.stop - contacts.start, 1), self.hardening)

    def static_overlap(self, force: np.ndarray, stiffness: np.ndarray, constants: np.ndarray) -> np.ndarray:
        """Return the root of k d + k3 d^3 = F by Newton's method from above."""
        overlap = force / stiffness
        for _ in range(60):
            cube = constants[:, 0] * overlap * overlap
            overlap = overlap - (overlap * (stiffness + cube) - force) / (stiffness + 3.0 * cube)
        return overlap


class Proportional(Cubic):
    """The cubic law with a constant derived from k and R*."""

    name: Literal["proportional"] = "proportional"  # type: ignore[assignment]

    def contact_constants(
        self, stiffness: np.ndarray, reduced_radius: np.ndarray, yield_strength: np.ndarray, contacts: slice
    ) -> np.ndarray:
        """Return a multiple of k / R*; the test's radius makes the quotient exact."""
        return (1e7 * stiffness / reduced_radius)[contacts, None]


@functions.contact_law.register(CubicContacts)
def cubic_contacts(kind, stiffness, constants, history):  # noqa: ANN001, ANN201
    """Return the law."""
    return CubicContacts(stiffness, constants[0])


@functions.force.register(CubicContacts)
def force(law, j, d):  # noqa: ANN001, ANN201
    """Return k d + k3 d^3."""
    return d * (law.stiffness[j] + law.hardening[j] * (d * d))


@functions.energy.register(CubicContacts)
def energy(law, j, d):  # noqa: ANN001, ANN201
    """Return k d^2 / 2 + k3 d^4 / 4."""
    return d * d * (0.5 * law.stiffness[j] + 0.25 * law.hardening[j] * (d * d))


@functions.force_pullback.register(CubicContacts)
def force_pullback(law, adjoint, j, d, slope):  # noqa: ANN001, ANN201
    """Add slope times the derivatives with respect to k and k3; return slope dF/dd."""
    k, cube = law.stiffness[j], law.hardening[j] * (d * d)
    adjoint.stiffness[j] += d * slope
    adjoint.hardening[j] += d * (d * d) * slope
    return (k + 3.0 * cube if d > 0.0 else 0.0) * slope


@functions.energy_pullback.register(CubicContacts)
def energy_pullback(law, adjoint, j, d, slope):  # noqa: ANN001, ANN201
    """Add slope times the derivatives with respect to k and k3."""
    adjoint.stiffness[j] += 0.5 * (d * d) * slope
    adjoint.hardening[j] += 0.25 * (d * d) * (d * d) * slope
