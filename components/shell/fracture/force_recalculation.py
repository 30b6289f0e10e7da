"""Gradients, forces and energies of points and nodes at new cracks, computed again with the remaining neighbours."""

from __future__ import annotations

import numpy as np

from ...materials.finite_strain import nominal_stress
from ...materials.tensors import load_deformation_gradient, load_symmetric_tensor
from ...support.float_arrays import FloatArray, ordered_sum
from ...support.jit import jit
from ..kernel_arrays import IntArray, Points, Scratch, Solid, State, support_entries
from ..kernels import write_point_pull


def displacement_gradients(points: Points, displacement: FloatArray, numbers: IntArray) -> FloatArray:
    """Return the displacement gradients of the points `numbers` with their present neighbours, (k, 9); bitwise as in a tick."""
    owner, neighbours, rows = support_entries(points, numbers)
    local = points.gradients[rows]
    terms = displacement[neighbours][:, :, None] * local[:, None, :]
    sums = np.array([np.bincount(owner, one, minlength=len(numbers)) for one in terms.reshape(-1, 9).T]).reshape(3, 3, -1)
    x, y, z = sums.swapaxes(0, 1)
    c, s = points.cosine[numbers], points.sine[numbers]
    return np.stack([x * points.along[numbers], c * y + s * z, c * z - s * y], axis=1).reshape(9, -1).T.copy()


def volume_ratios(gradients: FloatArray) -> FloatArray:
    """Return the relative volumes det(1 + H) for displacement gradients H, shape (k,)."""
    f = gradients.reshape(-1, 3, 3) + np.eye(3)
    minors = f[:, 1, [1, 2, 0]] * f[:, 2, [2, 0, 1]] - f[:, 1, [2, 0, 1]] * f[:, 2, [1, 2, 0]]
    return (f[:, 0, 0] * minors[:, 0] + f[:, 0, 1] * minors[:, 1]) + f[:, 0, 2] * minors[:, 2]


def half_kick_work(solid: Solid, state: State, point: int) -> float:
    """Return minus the work [J] of a point's stress on the nodes in the half kick before the stresses of the tick."""
    own, one, none, stress = slice(point, point + 1), np.ones(1), np.zeros(1), np.zeros((1, 9))
    write_pulls(state.gradient[own], state.stress[own], one, one, none, one, np.zeros(1, dtype=np.int64), stress)
    change = displacement_gradients(solid.points, state.displacement, np.array([point]))[0] - state.gradient[point]
    return 0.5 * float(solid.points.volume[point]) * ordered_sum(stress.reshape(3, 3).T.ravel() * change)


@jit
def write_pulls(gradient, stress, volume, cosine, sine, along, numbers, pull):
    """Write the pull (nominal stress times volume) of the points `numbers` from their stress and gradient, without ties."""
    for p in numbers:
        nominal = nominal_stress(load_deformation_gradient(gradient, p), load_symmetric_tensor(stress, p))
        write_point_pull(pull, p, nominal, volume[p], cosine[p], sine[p], along[p])


def write_pull(solid: Solid, state: State, scratch: Scratch, numbers: IntArray) -> None:
    """Write the pull (nominal stress times volume) of the points `numbers` of the body."""
    p = solid.points
    write_pulls(state.gradient, state.stress, p.volume, p.cosine, p.sine, p.along, numbers, scratch.pull)
