"""Specimens of several materials: the moduli of each automaton, and of the link between two.

Kernels take the moduli as an argument of their own: whether there are several materials is known from its dimensions when they
are compiled, and specimens of one material compute as if there were no others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.jit import internal_inlined
from .kernel_arrays import Body


class Mixture(NamedTuple):
    """Moduli of each automaton, and how the links between two materials divide their strains; see `strain_division`.

    Attributes:
        moduli: G and lambda of each automaton, shape (n, 2) [Pa]; shape (0,) where all are of one material.
        compliance: 1 / D of each link between two materials, 0 of the others, shape (n, slots) [1/Pa].
        division: scratch: what the own half of each link is strained more than the link, shape (n, slots).
    """

    moduli: FloatArray
    compliance: FloatArray
    division: FloatArray


def one_material() -> Mixture:
    """Return what stands for a specimen of one material, whose moduli are those of its `Body`."""
    return Mixture(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)))


def mix(body: Body, moduli: FloatArray) -> Mixture:
    """Return the mixture of automata with these moduli, shape (n, 2) [Pa]."""
    shear, lame = moduli[:, 0], moduli[:, 1]
    own = np.arange(len(body.kind))[:, np.newaxis]
    differ = (moduli[body.neighbours] != moduli[own]).any(axis=2) & (body.neighbours != own)
    share = body.share[body.kind]
    stiffening = 1.0 + body.missing[body.kind] * lame / (2.0 * shear)
    coupling = 0.5 * np.abs(lame) * (share * differ).sum(axis=1) / stiffening
    stiffness = (shear[own] + shear[body.neighbours]) + (coupling[own] + coupling[body.neighbours])
    return Mixture(moduli, np.where(differ, 1.0 / stiffness, 0.0), np.zeros(differ.shape))


@internal_inlined
def shear_of(moduli, i, whole):
    """Return G of an automaton [Pa]; `whole` is that of a specimen of one material."""
    if moduli.ndim == 2:
        return moduli[i, 0]
    return whole


@internal_inlined
def lame_of(moduli, i, whole):
    """Return lambda of an automaton [Pa]; `whole` is that of a specimen of one material."""
    if moduli.ndim == 2:
        return moduli[i, 1]
    return whole


@internal_inlined
def both_shear(moduli, i, j, whole):
    """Return the shear modulus of two halves of a link in series [Pa]."""
    if moduli.ndim == 2:
        one, other = moduli[i, 0], moduli[j, 0]
        return 2.0 * (one * other) / (one + other)
    return whole


@internal_inlined
def mean_shear(moduli, i, j, whole):
    """Return the mean of the shear moduli of two automata [Pa]."""
    if moduli.ndim == 2:
        return 0.5 * (moduli[i, 0] + moduli[j, 0])
    return whole


@internal_inlined
def volumetric_stress(moduli, division, i, j, slot, whole, theta_i, theta_j):
    """Return the mean of lambda theta of two automata, with what the division of the strain of their link adds [Pa]."""
    if moduli.ndim == 2:
        divided = (moduli[i, 0] - moduli[j, 0]) * division[i, slot]
        return 0.5 * (moduli[i, 1] * theta_i + moduli[j, 1] * theta_j) + divided
    return whole * (0.5 * (theta_i + theta_j))
