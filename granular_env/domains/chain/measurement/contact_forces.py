"""Forces and energies of contacts, by the chain's own law: what frames of overlaps and velocities tell of them."""

from __future__ import annotations

import numpy as np

from granular_env.components.chain import forces, layout
from granular_env.components.chain.laws import Law
from granular_env.components.chain.laws.functions import energy as contact_energy
from granular_env.components.chain.state import chain_state, state_of
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
        constants: of the law in addition to the stiffness, shape (n + 1, k).
        overlap: shape (T, n + 1), 0 where there is no contact [m].
        velocity: of the grains, shape (T, n) [m/s].
    """
    table, places = np.zeros((layout.FREE_ROW, layout.row_width(len(stiffness) - 1))), slice(0, len(stiffness))
    table[layout.STIFFNESS, places] = stiffness
    table[layout.LAW_CONSTANTS : layout.LAW_CONSTANTS + constants.shape[1], places] = constants.T
    table[layout.SCALARS, layout.GRAINS] = len(stiffness) - 1
    force, energy = np.empty_like(overlap), np.empty_like(overlap)
    _fill(state_of(law.contacts, table).law, table, overlap, velocity, force, energy)
    return force, energy


@jit
def _fill(law, table, overlap, velocity, force, energy):
    """Displacements stay 0: the overlaps of a frame are those of a chain that rests so."""
    chain = chain_state(law, table)
    forces.begin_histories(chain)
    for t in range(len(overlap)):
        forces.copy(overlap[t], table[layout.REST_OVERLAP])
        forces.copy(velocity[t], table[layout.V, 1:])
        forces.contact_forces(chain, force[t])
        for j in range(overlap.shape[1]):
            energy[t, j] = contact_energy(chain.law, j, forces.pressed(overlap[t, j]))
