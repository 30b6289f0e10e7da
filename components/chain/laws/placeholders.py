"""Placeholders for a contact law's functions and properties: loops call them, `specialise` puts a law's own in their place.

A law's file defines the functions of these names that the law needs; j is a contact, d its overlap where it is pressed and 0
where it is open, `a` the chain's table (`layout.py`). The law's constants of contact j are a[STIFFNESS, j] and the columns that
`Law.contact_constants` gives, a[LAW_CONSTANTS, j], a[LAW_CONSTANTS + 1, j] and so on; its history lies in the last rows before
DISSIPATED. `x_pullback(a, adjoint, j, d, slope)` adds slope times the derivative of x by each of these constants to `adjoint`.
"""

from __future__ import annotations

from typing import Any


class Property:
    """A yes or no about a law, which is a constant for the compiler: what it rules out is not compiled."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __bool__(self) -> bool:
        """Refuse to answer for no law."""
        return _refuse()


DISSIPATES = Property("DISSIPATES")
"""True where the force depends on the speed of approach, by `coefficient`."""
JUMPS = Property("JUMPS")
"""True where that part jumps when a contact closes."""
REMEMBERS = Property("REMEMBERS")
"""True where contacts have a history."""
LONG_FORMULA = Property("LONG_FORMULA")
"""True where `force` is so long that loops become vectors only where all forces are computed first."""


def _refuse() -> Any:
    raise NotImplementedError("no contact law is chosen: use specialise(function, law)")


def force(a, j, d):
    """Return the elastic force of contact j [N]."""
    return _refuse()


def energy(a, j, d):
    """Return the elastic energy that contact j would give back, were it unloaded now [J]."""
    return _refuse()


def force_slopes(a, j, d):
    """Return F, dF/dd, which is 0 where the contact is open, and dF/dk, k being the stiffness of the contact."""
    return _refuse()


def energy_pullback(a, adjoint, j, d, slope):
    """Add slope dE/dc to adjoint for each constant c of contact j."""
    return _refuse()


def coefficient(a, j, d):
    """Return the dissipative force of the closed contact j per speed of approach [N s/m]."""
    return _refuse()


def coefficient_pullback(a, adjoint, j, d, slope):
    """Add slope times the coefficient's derivative by each constant of contact j to adjoint; return slope times that by d."""
    return _refuse()


def begin(a, j):
    """Write the history of a contact that was never loaded."""
    return _refuse()


def remember(a, j, d):
    """Note what loading contact j to the overlap d has changed, and add the energy that it has cost to a[DISSIPATED, j]."""
    return _refuse()


def energy_root(a, j, d, rest):
    """Return the root of the energy of contact j above that at its overlap at rest, negative where it is less pressed."""
    return _refuse()


def energy_root_pullback(a, adjoint, j, d, rest, slope):
    """Add slope times its derivative by each constant of contact j to adjoint; return those by d and by `rest`, times slope."""
    return _refuse()


ELASTIC = ("force", "energy")
"""Every law has these."""
DISSIPATIVE = ("coefficient",)
HISTORY = ("begin", "remember")
ELASTIC_GRADIENT = ("force_slopes", "energy_pullback")
"""A law that has these too has gradients, unless it has a history."""
DISSIPATIVE_GRADIENT = ("coefficient_pullback",)
ENERGY_ROOT = ("energy_root", "energy_root_pullback")
"""Distances in the energy norm want these."""
