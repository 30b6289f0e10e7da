"""A contact law from outside the package, whose static overlap is not (F / k)^(1 / p): F = k d + k3 d^3."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from granular_env.components.chain.laws.law import Law
from granular_env.components.chain.layout import LAW_CONSTANTS, STIFFNESS
from granular_env.components.support.jit import inlined

HARDENING = LAW_CONSTANTS


class Cubic(Law):
    """F = k d + hardening d^3 while d > 0."""

    exponent: ClassVar[float] = 1.0
    needs_stiffness: ClassVar[bool] = True

    name: Literal["cubic"] = "cubic"
    hardening: float = 1e17

    def contact_constants(
        self, stiffness: np.ndarray, reduced_radius: np.ndarray, yield_strength: np.ndarray, contacts: slice
    ) -> np.ndarray:
        """Return k3."""
        return np.full((contacts.stop - contacts.start, 1), self.hardening)

    def overlap_at(self, force: np.ndarray, stiffness: np.ndarray, constants: np.ndarray) -> np.ndarray:
        """Return the root of k d + k3 d^3 = F by Newton's method from above."""
        overlap = force / stiffness
        for _ in range(60):
            cube = constants[:, 0] * overlap * overlap
            overlap = overlap - (overlap * (stiffness + cube) - force) / (stiffness + 3.0 * cube)
        return overlap


class Proportional(Cubic):
    """The same with a constant that follows from k and R*."""

    name: Literal["proportional"] = "proportional"  # type: ignore[assignment]

    def contact_constants(
        self, stiffness: np.ndarray, reduced_radius: np.ndarray, yield_strength: np.ndarray, contacts: slice
    ) -> np.ndarray:
        """Return a multiple of k / R*: the radius of the test makes the quotient exact."""
        return (1e7 * stiffness / reduced_radius)[contacts, None]


@inlined
def force(a, j, d):
    """Return k d + k3 d^3."""
    return d * (a[STIFFNESS, j] + a[HARDENING, j] * (d * d))


@inlined
def energy(a, j, d):
    """Return k d^2 / 2 + k3 d^4 / 4."""
    return d * d * (0.5 * a[STIFFNESS, j] + 0.25 * a[HARDENING, j] * (d * d))


@inlined
def force_slopes(a, j, d):
    """Return F, dF/dd and dF/dk."""
    k, cube = a[STIFFNESS, j], a[HARDENING, j] * (d * d)
    return d * (k + cube), k + 3.0 * cube if d > 0.0 else 0.0, d


@inlined
def energy_pullback(a, adjoint, j, d, slope):
    """Add slope times the derivatives by k and k3."""
    adjoint[STIFFNESS, j] += 0.5 * (d * d) * slope
    adjoint[HARDENING, j] += 0.25 * (d * d) * (d * d) * slope
