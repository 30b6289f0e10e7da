"""Energies, momentum, principal stresses and the smallest stretch of the solid as it is."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from ..materials.tensors import SymmetricTensor, elastic_energy_density, largest_principal, load_deformation, load_symmetric
from ..materials.thermoviscoplastic import elastic_moduli
from ..support.jit import jit
from .hourglass import hourglass_energy
from .kernel_arrays import Solid, State
from .kernels import wall_depth

STORED = ("kinetic_energy", "elastic_energy", "hourglass_energy", "wall_energy", "leapfrog_energy")


@jit
def sum_nodes(body, state, out):
    """Write kinetic energy, the sum of force^2 / mass where nodes are free, and momentum, shape (5,)."""
    kinetic, pulled, px, py, pz = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(body.mass.size):
        mass = body.mass[j]
        x, y, z = state.velocity[j, 0], state.velocity[j, 1], state.velocity[j, 2]
        kinetic += 0.5 * mass * (x * x + y * y + z * z)
        px, py, pz = px + mass * x, py + mass * y, pz + mass * z
        for i in range(3):
            if body.prescribed[j, i] == 0:
                pulled += state.force[j, i] * state.force[j, i] / mass
    out[0], out[1], out[2], out[3], out[4] = kinetic, pulled, px, py, pz


@jit
def sum_points(solid, state, out):
    """Write the elastic energy and the plastic work, shape (2,) [J]."""
    elastic, plastic, law = 0.0, 0.0, solid.law
    moduli = elastic_moduli(law, law.reference_temperature)
    for p in range(solid.body.volume.size):
        if solid.plastic:
            moduli = elastic_moduli(law, state.temperature[p])
            plastic += solid.body.volume[p] * state.plastic_work[p]
        elastic += solid.body.volume[p] * elastic_energy_density(load_symmetric(state.stress, p), moduli)
    out[0], out[1] = elastic, plastic


@jit
def wall_energy(solid, state):
    """Return the energy of the springs of the wall [J]."""
    energy = 0.0
    for j in range(solid.body.bounce.size):
        depth = wall_depth(solid, state, j)
        energy += 0.5 * solid.body.bounce[j] * depth * depth
    return energy


@jit
def write_largest_principal(stress, out):
    """Write the largest principal stress of each point [Pa]."""
    for p in range(out.size):
        out[p] = largest_principal(load_symmetric(stress, p)).value


@jit
def smallest_stretch(gradient):
    """Return the smallest principal stretch of all points: the root of the least eigenvalue of F^T F, at least 1e-6."""
    least = 1.0e300
    for p in range(gradient.shape[0]):
        f = load_deformation(gradient, p)
        square = SymmetricTensor(
            -(f.xx * f.xx + f.yx * f.yx + f.zx * f.zx), -(f.xy * f.xy + f.yy * f.yy + f.zy * f.zy),
            -(f.xz * f.xz + f.yz * f.yz + f.zz * f.zz), -(f.xx * f.xy + f.yx * f.yy + f.zx * f.zy),
            -(f.xy * f.xz + f.yy * f.yz + f.zy * f.zz), -(f.xz * f.xx + f.yz * f.yx + f.zz * f.zx),
        )  # fmt: skip
        least = min(least, -largest_principal(square).value)
    return sqrt(max(least, 1e-12))


def measure(solid: Solid, state: State) -> dict[str, Any]:
    """Return the energies of `STORED` and the plastic work [J], their sum `energy` without the latter, and the momentum."""
    nodes, points = np.zeros(5), np.zeros(2)
    sum_nodes(solid.body, state, nodes)
    sum_points(solid, state, points)
    found: dict[str, Any] = {
        "kinetic_energy": float(nodes[0]),
        "elastic_energy": float(points[0]),
        "hourglass_energy": float(hourglass_energy(solid, state)),
        # Not compiled for bodies without a wall.
        "wall_energy": float(wall_energy(solid, state)) if solid.body.bounce.size else 0.0,
        "leapfrog_energy": -0.125 * solid.step * solid.step * float(nodes[1]),
    }
    return {
        **found,
        "energy": sum(found[name] for name in STORED),
        "plastic_work": float(points[1]),
        "momentum": nodes[2:5].copy(),
    }
