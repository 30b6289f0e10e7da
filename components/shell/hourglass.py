"""Hourglass control: ties (springs) between neighbouring columns against modes that integration points at columns miss.

The derivative in the middle of three columns vanishes for displacements that alternate from column to column. Between columns
C and D at a distance X the mean displacements through the thickness must follow the mean of both gradients H,

    r = (u_D - u_C) - (H_C + H_D) X / 2,    energy k r^2 / 2,    k = alpha E A / |X|.

A is the section between the columns. r vanishes to third order for a smooth field, so that bending is not stiffened, and is
twice the amplitude of an alternating one. All forces derive from the energy and conserve (angular) momentum; their limit is the
flow stress times A. Source: idea of G. C. Ganzenmüller, Comput. Methods Appl. Mech. Eng. 286 (2015) 87, with both gradients.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..materials.thermoviscoplastic import LEAST_FLOW, flow_stress
from ..support.float_arrays import ordered_sum
from ..support.jit import internal, internal_inlined, jit
from .geometry.lattice import Lattice, column_neighbours
from .kernel_arrays import Hourglass, IntArray, Tables


@internal
def tie_misfit(ties, u, h, c, d):
    """Return r of the tie from column c to column d [m]: x, y, z."""
    dx, dy, dz = column_distance(ties.place, c, d)
    x, y, z = 0.0, 0.0, 0.0
    for layer in range(ties.layers):
        a, b = c * ties.layers + layer, d * ties.layers + layer
        # Below a notch the shares of the layers of nodes in the mean differ.
        share, other = ties.shares[a], ties.shares[b] - ties.shares[a]
        x += share * (u[b, 0] - u[a, 0]) + other * u[b, 0]
        y += share * (u[b, 1] - u[a, 1]) + other * u[b, 1]
        z += share * (u[b, 2] - u[a, 2]) + other * u[b, 2]
    part = 0.5 / ties.points
    for point in range(ties.points):
        p, q = c * ties.points + point, d * ties.points + point
        x -= part * ((h[p, 0] + h[q, 0]) * dx + (h[p, 1] + h[q, 1]) * dy + (h[p, 2] + h[q, 2]) * dz)
        y -= part * ((h[p, 3] + h[q, 3]) * dx + (h[p, 4] + h[q, 4]) * dy + (h[p, 5] + h[q, 5]) * dz)
        z -= part * ((h[p, 6] + h[q, 6]) * dx + (h[p, 7] + h[q, 7]) * dy + (h[p, 8] + h[q, 8]) * dz)
    return x, y, z


@internal_inlined
def column_distance(place, c, d):
    """Return the vector from column c to column d [m]: x, y, z."""
    return place[d, 0] - place[c, 0], place[d, 1] - place[c, 1], place[d, 2] - place[c, 2]


@internal
def smallest_flow_stress(law, plastic_strain, temperature, column, count):
    """Return the smallest flow stress of the points of a column [Pa]."""
    least = np.inf
    for p in range(column * count, (column + 1) * count):
        least = min(least, flow_stress(law, plastic_strain[p], temperature[p]))
    return least


@jit
def write_tie_forces(ties, points, law, is_plastic, state, scratch, columns):
    """Write forces and energies of the ties of some columns, and add their stresses to the pull of the points of these columns.

    Half of the energy of a tie belongs to each of its columns; beyond the largest force the energy is that of a constant force.

    Args:
        ties: `kernel_arrays.Hourglass`.
        points: `kernel_arrays.Points`.
        law: `FlowConstants` of the material.
        is_plastic: whether the material can yield.
        state: `kernel_arrays.State`.
        scratch: `kernel_arrays.Scratch`.
        columns: numbers of the columns, shape (k,).
    """
    pull, count = scratch.pull, ties.points
    for number in range(columns.size):
        c = columns[number]
        fx, fy, fz, own = 0.0, 0.0, 0.0, 0.0
        txx, txy, txz, tyx, tyy, tyz, tzx, tzy, tzz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for side in range(4):
            d = np.int64(ties.partner[c, side])
            energy = 0.0
            if d >= 0:
                x, y, z = tie_misfit(ties, state.displacement, state.gradient, c, d)
                stiffness, long = ties.stiffness[c, side], sqrt(x * x + y * y + z * z)
                size, scale, most = stiffness * long, stiffness, np.inf
                if is_plastic and size > ties.section[c, side] * law.yield_stress * LEAST_FLOW:
                    if own == 0.0:
                        own = smallest_flow_stress(law, state.plastic_strain, state.temperature, c, count)
                    other = smallest_flow_stress(law, state.plastic_strain, state.temperature, d, count)
                    most = min(own, other) * ties.section[c, side]
                if size > most:
                    scale = scale * most / size
                    energy = 0.5 * (most * (long - 0.5 * most / stiffness))
                else:
                    energy = 0.25 * stiffness * long * long
                x, y, z = scale * x, scale * y, scale * z
                fx, fy, fz = fx + x, fy + y, fz + z
                dx, dy, dz = column_distance(ties.place, c, d)
                txx, txy, txz = txx + dx * x, txy + dx * y, txz + dx * z
                tyx, tyy, tyz = tyx + dy * x, tyy + dy * y, tyz + dy * z
                tzx, tzy, tzz = tzx + dz * x, tzy + dz * y, tzz + dz * z
            scratch.tie_energy[c, side] = energy
        scratch.column_force[c, 0], scratch.column_force[c, 1], scratch.column_force[c, 2] = fx, fy, fz
        part = 0.5 / count
        for p in range(c * count, (c + 1) * count):
            cosine, sine = part * points.cosine[p], part * points.sine[p]
            along = part * points.along[p]
            pull[p, 0] -= along * txx
            pull[p, 1] -= along * txy
            pull[p, 2] -= along * txz
            pull[p, 3] -= cosine * tyx - sine * tzx
            pull[p, 4] -= cosine * tyy - sine * tzy
            pull[p, 5] -= cosine * tyz - sine * tzz
            pull[p, 6] -= sine * tyx + cosine * tzx
            pull[p, 7] -= sine * tyy + cosine * tzy
            pull[p, 8] -= sine * tyz + cosine * tzz


def tie_energy(tables: Tables, columns: IntArray) -> float:
    """Return half of the energy of the ties of some columns; the other half belongs to the other columns [J].

    It is computed by the kernel of a tick, which writes to the scratch.
    """
    solid, state, scratch, _ = tables
    write_tie_forces(solid.hourglass, solid.points, solid.law, solid.plastic, state, scratch, columns)
    return ordered_sum(scratch.tie_energy[columns])


def make_hourglass(lattice: Lattice, points: int, young: float, alpha: float) -> Hourglass:
    """Return the ties of a body whose points lie at the columns.

    A column at an end of an axis has a one-sided derivative, which resolves these modes: ties along the axis end before it.

    Args:
        lattice: the body.
        points: number of integration points of a column.
        young: Young's modulus [Pa].
        alpha: stiffness of the ties over that of the material between the columns; 0 for no ties.
    """
    n, m, layers = lattice.shape
    if alpha == 0.0:
        nothing = np.zeros((0, 4))
        return Hourglass(layers, 1, np.zeros(lattice.node_count), np.zeros((0, 3)), nothing.astype(np.int32), nothing, nothing)
    volumes = lattice.volumes.reshape(n * m, layers)
    shares = volumes / volumes.sum(axis=1)[:, None] if lattice.hollow else np.tile(volumes[0] / volumes[0].sum(), (n * m, 1))
    place = (lattice.nodes.reshape(n * m, layers, 3) * shares[..., None]).sum(axis=1)
    around = column_neighbours(n, m, lattice.axes[1].is_closed)
    along, across = np.divmod(np.arange(n * m), m)
    inner = np.stack([(along > 0) & (along < n - 1), lattice.axes[1].is_closed | ((across > 0) & (across < m - 1))], axis=1)
    inner = np.repeat(inner, 2, axis=1)
    partner = np.where(inner & inner[around, np.arange(4)], around, -1)
    apart = place[partner] - place[:, None]
    distance = np.sqrt(apart[..., 0] ** 2 + apart[..., 1] ** 2 + apart[..., 2] ** 2)
    distance = np.where(partner >= 0, distance, 1.0)
    # Volume of half of both columns over their distance, i.e. the area of the section between them.
    section = 0.5 * (volumes.sum(axis=1)[:, None] + volumes.sum(axis=1)[partner]) / distance
    section = np.where(partner >= 0, section, 0.0)
    return Hourglass(
        layers, points, shares.ravel(), place, partner.astype(np.int32), alpha * young * section / distance, section
    )
