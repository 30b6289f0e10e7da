"""Forces and energies of contacts, by the chain's own law: what frames of overlaps and velocities tell of them."""

from __future__ import annotations

import numpy as np

from granular_env.components.chain import equations_of_motion as equations
from granular_env.components.chain import layout
from granular_env.components.chain.laws import Law
from granular_env.components.chain.laws import placeholders as law_functions
from granular_env.components.chain.specialisation import specialise
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit


def forces_and_energies(
    law: Law, stiffness: FloatArray, constants: FloatArray, overlap: FloatArray, velocity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Compressive force [N] and stored energy [J] of each contact in each frame, both of shape (T, n + 1).

    They have the bits of the chain's own `contact_force`. A contact with a history counts as never loaded before.

    Args:
        law: the contact law.
        stiffness: shape (n + 1,), 0 where there is no contact.
        constants: what the law wants to know of each contact, shape (n + 1, k).
        overlap: shape (T, n + 1), 0 where there is no contact [m].
        velocity: of the grains, shape (T, n) [m/s].
    """
    a = _chain(law, stiffness, constants)
    force, energy = np.empty_like(overlap), np.empty_like(overlap)
    specialise(_fill, type(law))(a, overlap, velocity, force, energy)
    return force, energy


def _chain(law: Law, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
    """Return the kernels' table of a chain, as far as contacts need it."""
    places = slice(0, len(stiffness))
    a = np.zeros((layout.FREE_ROW, layout.row_width(len(stiffness) - 1)))
    a[layout.STIFFNESS, places] = stiffness
    a[layout.LAW_CONSTANTS : layout.LAW_CONSTANTS + constants.shape[1], places] = constants.T
    a[layout.SCALARS, layout.GRAINS], a[layout.SCALARS, layout.EXPONENT] = len(stiffness) - 1, law.exponent
    if law.has_history:
        specialise(equations.begin_histories, type(law))(a)
    return a


@jit
def _fill(a, overlap, velocity, force, energy):
    """Displacements stay 0: the overlaps of a frame are those of a chain that rests so."""
    grains = velocity.shape[1]
    for t in range(len(overlap)):
        a[layout.REST_OVERLAP, : grains + 1] = overlap[t]
        a[layout.V, 1 : grains + 1] = velocity[t]
        equations.contact_forces(a, layout.U, layout.V, force[t])
        for j in range(grains + 1):
            energy[t, j] = law_functions.energy(a, j, equations.pressed(overlap[t, j]))
