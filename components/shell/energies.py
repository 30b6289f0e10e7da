"""Present energies, momentum and smallest stretch of the solid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..materials.tensors import elastic_energy_density, largest_principal, load_symmetric_tensor
from ..materials.thermoviscoplastic import elastic_moduli
from ..support.float_arrays import FloatArray, ordered_sum, ordered_sum_of_rows
from ..support.jit import jit
from .hourglass import tie_energy
from .kernel_arrays import IntArray, Solid, State, Tables
from .ticks import wall_depths

STORED = ("kinetic_energy", "elastic_energy", "hourglass_energy", "wall_energy", "leapfrog_energy")


@jit
def write_elastic_densities(law, stress, temperature, out):
    """Write the elastic energy per volume of points [J/m^3]; at the reference temperature if `temperature` has no entries."""
    moduli = elastic_moduli(law, law.reference_temperature)
    for p in range(out.size):
        if temperature.size > 0:
            moduli = elastic_moduli(law, temperature[p])
        out[p] = elastic_energy_density(load_symmetric_tensor(stress, p), moduli)


@jit
def write_largest_principal_values(stress, out):
    """Write the largest principal value of each symmetric tensor, a row of `stress`, shape (m, 6)."""
    for p in range(out.size):
        out[p] = largest_principal(load_symmetric_tensor(stress, p)).value


def elastic_energy(solid: Solid, state: State, points: IntArray | slice = slice(None)) -> float:
    """Return the elastic energy of some points, by default of all points [J]."""
    volume, temperature = solid.points.volume[points], state.temperature[points] if solid.plastic else np.zeros(0)
    density = np.zeros(len(volume))
    write_elastic_densities(solid.law, state.stress[points], temperature, density)
    return ordered_sum(volume * density)


def leapfrog_energy(solid: Solid, state: State, nodes: IntArray | slice = slice(None)) -> float:
    """Return the part of some nodes in the leapfrog energy: -h^2/8 times their sum of force^2 / mass [J]."""
    mass, force, free = solid.nodes.mass[nodes], state.force[nodes], solid.nodes.prescribed[nodes] == 0
    return -0.125 * solid.step * solid.step * ordered_sum((force * force / mass[:, None])[free])


def smallest_stretch(gradient: FloatArray) -> float:
    """Return the smallest principal stretch of all points, at least 1e-6: the root of the smallest eigenvalue of F^T F."""
    f = gradient.reshape(-1, 3, 3) + np.eye(3)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    square, largest = np.stack([-(f[:, :, i] * f[:, :, j]).sum(axis=1) for i, j in pairs], axis=1), np.zeros(len(f))
    write_largest_principal_values(square, largest)
    return math.sqrt(max(-float(largest.max()), 1e-12))


def energies_and_momentum(tables: Tables) -> dict[str, Any]:
    """Return a dictionary: the energies in `STORED`, plastic work, `energy` (sum of the stored ones) [J], and momentum."""
    solid, state, _, _ = tables
    mass, (x, y, z) = solid.nodes.mass, state.velocity.T
    depth = wall_depths(solid, state)
    stored = (
        ordered_sum(0.5 * mass * (x * x + y * y + z * z)),
        elastic_energy(solid, state),
        tie_energy(tables, np.arange(len(solid.hourglass.partner))),
        ordered_sum(0.5 * solid.bounce * depth * depth),
        leapfrog_energy(solid, state),
    )
    found: dict[str, Any] = dict(zip(STORED, map(float, stored), strict=True))
    return {
        **found,
        "energy": ordered_sum(*found.values()),
        "plastic_work": ordered_sum(solid.points.volume * state.plastic_work) if solid.plastic else 0.0,
        "momentum": ordered_sum_of_rows(mass[:, None] * state.velocity),
    }
