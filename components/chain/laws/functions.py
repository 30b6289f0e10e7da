"""The functions of a contact law, which kernels call; each chooses the implementation for the class of the law.

A law in a kernel is a `NamedTuple` whose fields are arrays with one number for each contact: the stiffness, further constants,
and the contact's history. Its file registers the functions that the law needs, for example ``force.register(HertzContacts)``;
j is a contact, d its overlap where it is pressed and 0 where it is open. In ``x_pullback(law, adjoint, j, d, slope)``
`adjoint` is a law of the same class, whose arrays take the derivatives: slope times the derivative of x by each constant
of contact j is added to them.
"""

from __future__ import annotations

from functools import partial

from ...support.dispatch import dispatched

_required = partial(dispatched, inlined=True)
_optional = partial(dispatched, inlined=True, has_default=True)


@dispatched
def contact_law(kind, stiffness, constants, history):
    """Return the law of class `kind`, with its arrays.

    Args:
        kind: the class.
        stiffness: one row.
        constants: three rows; the first ones are the columns that `Law.contact_constants` returns.
        history: three rows; a law with k history rows has the last k.
    """


@_required
def force(law, j, d):
    """Return the elastic force of contact j [N]."""


@_required
def energy(law, j, d):
    """Return the elastic energy that contact j would give back if it were unloaded now [J]."""


@_optional
def damping(law, j, d):
    """Return the dissipative force of the closed contact j per speed of approach [N s/m]."""
    return 0.0


@_optional
def jumps(law):
    """Return whether the dissipative force jumps when a contact closes."""
    return False


@_optional
def remembers(law):
    """Return whether contacts have a history."""
    return False


@_optional
def begin(law, j):
    """Write the history of a contact that was never loaded."""


@_optional
def remember(law, j, d):
    """Update the history of contact j, loaded to the overlap d; return the energy that this has dissipated [J]."""
    return 0.0


@_required
def force_pullback(law, adjoint, j, d, slope):
    """Add slope dF/dc to the adjoint of each constant c; return slope dF/dd, which is 0 where the contact is open."""


@_required
def energy_pullback(law, adjoint, j, d, slope):
    """Add slope dE/dc to the adjoint of each constant c."""


@_optional
def damping_pullback(law, adjoint, j, d, slope):
    """Add slope times the derivative of the damping by each constant; return slope times that by d."""
    return 0.0


@_required
def energy_root(law, j, d, rest):
    """Return the root of the energy of contact j above that at its overlap at rest, negative where it is less pressed."""


@_required
def energy_root_pullback(law, adjoint, j, d, rest, slope):
    """Add slope times its derivative by each constant; return those by d and by `rest`, times slope."""


ELASTIC = (contact_law, force, energy)
"""Every law has these."""
DISSIPATIVE = (damping,)
HISTORY = (remembers, begin, remember)
ELASTIC_GRADIENT = (force_pullback, energy_pullback)
"""A law that has these too has gradients, unless it has a history."""
DISSIPATIVE_GRADIENT = (damping_pullback,)
ENERGY_ROOT = (energy_root, energy_root_pullback)
"""Distances in the energy norm need these."""
