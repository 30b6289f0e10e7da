"""Gradients, forces and energies computed anew around new cracks, with the neighbours that are left."""

from __future__ import annotations

import numpy as np

from ...materials.finite_strain import nominal_stress
from ...materials.tensors import elastic_energy_density, load_deformation, load_symmetric
from ...materials.thermoviscoplastic import elastic_moduli
from ...support.float_arrays import FloatArray
from ...support.jit import jit
from ..hourglass import add_energy_of_ties, hold_columns
from ..kernel_arrays import IntArray, Solid, State
from ..kernels import gather_forces, write_point_pull


def new_gradients(solid: Solid, state: State, points: IntArray) -> FloatArray:
    """Return the displacement gradients of k points as they see the nodes now, shape (k, 9)."""
    out = np.zeros((len(points), 9))
    write_gradients(solid, state, points, out)
    return out


def volume_ratios(gradients: FloatArray) -> FloatArray:
    """Return the volumes over those at the start that displacement gradients mean, shape (k,)."""
    f = gradients.reshape(-1, 3, 3) + np.eye(3)
    minors = f[:, 1, [1, 2, 0]] * f[:, 2, [2, 0, 1]] - f[:, 1, [2, 0, 1]] * f[:, 2, [1, 2, 0]]
    return (f[:, 0, 0] * minors[:, 0] + f[:, 0, 1] * minors[:, 1]) + f[:, 0, 2] * minors[:, 2]


def work_of_half_kick(solid: Solid, state: State, point: int) -> float:
    """Return minus the work of a point's stress on the nodes in the half kick before a tick's new stresses [J]."""
    pull = np.zeros(9)
    change = new_gradients(solid, state, np.array([point]))[0] - state.gradient[point]
    write_nominal_stress(state, point, pull)
    stress = pull.reshape(3, 3)
    work = 0.0
    for i in range(3):
        for j in range(3):
            work += float(stress[j, i]) * float(change[3 * i + j])
    return 0.5 * float(solid.body.volume[point]) * work


@jit
def write_nominal_stress(state, p, out):
    """Write the nominal stress of a point, shape (9,)."""
    nominal = nominal_stress(load_deformation(state.gradient, p), load_symmetric(state.stress, p))
    out[0], out[1], out[2], out[3], out[4], out[5], out[6], out[7], out[8] = nominal


@jit
def write_gradients(solid, state, points, out):
    """Write the displacement gradients of k points as they see the nodes now, shape (k, 9); the state stays as it is."""
    body, u = solid.body, state.displacement
    for number in range(points.size):
        p = points[number]
        row = body.first[body.kind[p]]
        c, s = body.cosine[p], body.sine[p]
        for i in range(3):
            x, y, z = 0.0, 0.0, 0.0
            for slot in range(body.begin[p + 1] - body.begin[p]):
                value = u[body.lowest[p] + body.offsets[body.begin[p] + slot], i]
                x += value * body.gradients[row + slot, 0]
                y += value * body.gradients[row + slot, 1]
                z += value * body.gradients[row + slot, 2]
            x *= body.along[p]
            out[number, 3 * i], out[number, 3 * i + 1], out[number, 3 * i + 2] = x, c * y + s * z, c * z - s * y


@jit
def write_pull(solid, state, scratch, points):
    """Write what some points pull with, without ties, from the stresses and gradients as they are."""
    for p in points:
        nominal = nominal_stress(load_deformation(state.gradient, p), load_symmetric(state.stress, p))
        write_point_pull(solid.body, p, nominal, scratch.pull)


@jit
def refresh_forces(solid, state, scratch, points, columns, nodes):
    """Write the forces on some nodes from the stresses and gradients as they are.

    Args:
        solid: `kernel_arrays.Solid`.
        state: of the tick that has just been made.
        scratch: of the same tick.
        points: those whose pull changes.
        columns: those whose ties change.
        nodes: all that these points and columns pull at.
    """
    write_pull(solid, state, scratch, points)
    for c in columns:
        hold_columns(solid, state, scratch, c, c + 1)
    for j in nodes:
        gather_forces(solid, state, scratch, j, j + 1)


@jit
def tie_energy(solid, state, columns):
    """Return the energy of the ties of some columns, half of each [J]."""
    energy = 0.0
    for c in columns:
        energy = add_energy_of_ties(solid, state, c, energy)
    return energy


@jit
def leapfrog_energy(solid, state, nodes):
    """Return the part of some nodes of the energy that the scheme adds: -h^2/8 times the sum of force^2 / mass [J]."""
    total = 0.0
    for j in nodes:
        for i in range(3):
            if solid.body.prescribed[j, i] == 0:
                total += state.force[j, i] * state.force[j, i] / solid.body.mass[j]
    return -0.125 * solid.step * solid.step * total


@jit
def erode(solid, state, points):
    """Take the stress from some points, and return the elastic energy that they had [J]."""
    law, energy = solid.law, 0.0
    moduli = elastic_moduli(law, law.reference_temperature)
    for p in points:
        if solid.plastic:
            moduli = elastic_moduli(law, state.temperature[p])
        energy += solid.body.volume[p] * elastic_energy_density(load_symmetric(state.stress, p), moduli)
        state.stress[p] = 0.0
        state.gradient[p] = 0.0
    return energy
