"""The histories of links that may yield and break, and their strains; see `inelastic_links`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.jit import inlined, internal_inlined, jit
from .kernel_arrays import Body
from .material_mixture import Mixture
from .pair import strains, turned


class Bonds(NamedTuple):
    """The histories of links; each is kept at both of its ends.

    Attributes:
        weight: 1 for a link that holds, less while it is released, 0 afterwards; shape (n, slots).
        plastic: plastic strains along and across, shape (n, slots, 2).
        stiffness: part of the shear modulus that is left, less 1, shape (n, slots).
        inelastic: inelastic strain, shape (n, slots).
        origin: strains along and across from which those of a link count, shape (n, slots, 2); where no pair is linked again
            they are all 0, and this has shape (0, slots).
        mixture: moduli of automata of several materials; no part of the state.
    """

    weight: FloatArray
    plastic: FloatArray
    stiffness: FloatArray
    inelastic: FloatArray
    origin: FloatArray
    mixture: Mixture


def intact_bonds(body: Body, mixture: Mixture) -> Bonds:
    """Return links that all hold."""
    shape = body.neighbours.shape
    plastic, origin = np.zeros((*shape, 2)), np.zeros((0, shape[1]))
    return Bonds(np.ones(shape), plastic, np.zeros(shape), np.zeros(shape), origin, mixture)


@inlined
def opposite_slot(slots, slot):
    """Return the slot of the same pair at its other end."""
    return slot + slots // 2 if slot < slots // 2 else slot - slots // 2


@internal_inlined
def pair_strains(body, displacement, half, i, slot):
    """Return the strains of a pair since anything moved, and cos - 1 and sin of its rotation."""
    nx, ny, j = body.directions[slot, 0], body.directions[slot, 1], body.neighbours[i, slot]
    return strains(displacement, half, i, j, nx, ny, body.diameter)


@internal_inlined
def origin_of(origin, i, slot):
    """Return the strains from which those of a link count; which of the two is known when this is compiled.

    A question to be answered for each link would make everything around it ten times as slow.
    """
    if origin.ndim == 3:
        return origin[i, slot, 0], origin[i, slot, 1]
    return 0.0, 0.0


@internal_inlined
def bond_strains(body, bonds, displacement, half, i, slot):
    """Return the strains of a link, from those on that it was made with, and cos - 1 and sin of its rotation."""
    eps, gamma, less, sine = pair_strains(body, displacement, half, i, slot)
    along, across = origin_of(bonds.origin, i, slot)
    return eps - along, gamma - across, less, sine


@jit
def largest_bond_strain(body, bonds, displacement, half):
    """Return the largest strain along or across a link that holds; arguments as for `bond_strains`."""
    largest = 0.0
    for i in range(body.kind.size):
        for slot in range(body.directions.shape[0] // 2):
            if body.neighbours[i, slot] != i and bonds.weight[i, slot] == 1.0:
                eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
                largest = max(largest, abs(eps), abs(gamma))
    return largest


@internal_inlined
def strain_rates(body, motion, half, i, slot):
    """Return the rates of the strains of a pair, along and across [1/s]."""
    eps, gamma, less, sine = pair_strains(body, motion.displacement, half, i, slot)
    j, inverse = body.neighbours[i, slot], 1.0 / body.diameter
    nx, ny = turned(1.0, 0.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    vx, vy = motion.velocity[j, 0] - motion.velocity[i, 0], motion.velocity[j, 1] - motion.velocity[i, 1]
    turning = 0.5 * (motion.spin[i] + motion.spin[j])
    return (vx * nx + vy * ny) * inverse + turning * gamma, (vy * nx - vx * ny) * inverse - turning * (1.0 + eps)


@internal_inlined
def free_share(body, bonds, i, kind, slot):
    """Return what a released face adds to the shares of free faces; its stiffness is what is left of that of the link."""
    if bonds.weight[i, slot] == 1.0:
        return 0.0
    return (1.0 - bonds.weight[i, slot]) * body.share[kind, slot] / (1.0 + bonds.stiffness[i, slot])
