"""The kernel functions of contact laws; each dispatches on the class of the law.

In a kernel a law is a `NamedTuple` whose fields are arrays with one number per contact: the stiffness, other constants, and the
history of the contact. The module of a law registers its functions, for example ``force.register(HertzContacts)``. j is a
contact, d its overlap if it is closed and 0 if it is open. In ``x_pullback(law, adjoint, j, d, slope)``, `slope` is dJ/dx for
an objective J, and `adjoint` is a law of the same class; its arrays hold the derivatives of J with respect to the constants.
"""

from __future__ import annotations

from functools import partial

from ...support.dispatch import dispatch_by_class

_required = partial(dispatch_by_class, inlined=True)
_optional = partial(dispatch_by_class, inlined=True, has_default=True)


@dispatch_by_class
def contact_law(kind, stiffness, constants, history):
    """Return the law of class `kind`, with its arrays.

    Args:
        kind: class of the law.
        stiffness: a row of the table.
        constants: three rows, of which the first ones are the columns that `Law.contact_constants` returns.
        history: three rows; a law with k history rows uses the last k.
    """


@_required
def force(law, j, d):
    """Return the elastic force of contact j [N]."""


@_required
def energy(law, j, d):
    """Return the elastic energy that contact j would release on unloading [J]."""


@_optional
def damping(law, j, d):
    """Return the dissipative force of the closed contact j per speed of approach [N s/m]."""
    return 0.0


@_optional
def has_force_jump(law):
    """Return whether the dissipative force jumps when a contact closes."""
    return False


@_optional
def has_history(law):
    """Return whether contacts have a history."""
    return False


@_optional
def begin_history(law, j):
    """Write the history of a contact that has never been loaded."""


@_optional
def update_history(law, j, d):
    """Update the history of contact j, loaded to the overlap d; return the dissipated energy [J]."""
    return 0.0


@_required
def force_pullback(law, adjoint, j, d, slope):
    """Add slope * (dF/dc) to the adjoint of each constant c of the force F; return slope * (dF/dd), 0 for an open contact."""


@_required
def energy_pullback(law, adjoint, j, d, slope):
    """Add slope * (dE/dc) to the adjoint of each constant c of the energy E."""


@_optional
def damping_pullback(law, adjoint, j, d, slope):
    """Add slope * d(damping)/dc to the adjoint of each constant c; return slope * d(damping)/dd."""
    return 0.0


@_required
def energy_root(law, j, d, rest):
    """Return the root q of the energy of contact j above its energy at rest, negative if it is less compressed [J^0.5]."""


@_required
def energy_root_pullback(law, adjoint, j, d, rest, slope):
    """Add slope * (dq/dc) to the adjoint of each constant c of the root q; return slope * (dq/dd) and slope * (dq/drest)."""


ELASTIC = (contact_law, force, energy)
"""Functions that every law has."""
DISSIPATIVE = (damping,)
HISTORY = (has_history, begin_history, update_history)
ELASTIC_GRADIENT = (force_pullback, energy_pullback)
"""Additional functions of a law with gradients; a law with a history has none."""
DISSIPATIVE_GRADIENT = (damping_pullback,)
ENERGY_ROOT = (energy_root, energy_root_pullback)
"""Functions for the distance of two states by roots of the energy, see `differentiable_quantities`."""
