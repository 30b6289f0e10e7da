"""Tied faces beside links that are made anew; see `zigzag_strains`.

A tied face has the mean weight of the two links beside it, so that it is linked again as they are. As the weight rises from w
to v, the strain from which that of the face counts is set anew, so that the face carries what it carried, nothing at first:

    v (2 G g e + lambda theta) = w (2 G g e + lambda theta) before it,        v 2 G g gamma_e = w 2 G g gamma_e before it

with the elastic strains e and gamma_e. theta has its part in that: with share c of the face, v c e / (1 + a).
"""

from __future__ import annotations

from ..support.jit import internal, internal_inlined
from .volumetric_strain import bond_dilation, condensation
from .zigzag_faces import face_strains, whole_face
from .zigzag_strains import face_weight, tied_strains


@internal_inlined
def _face_beside(ties, i, slot):
    """Return the row of the tied face of an automaton that goes with the link in a slot, -1 without."""
    place = ties.place[i]
    if place < 0 or slot == 0 or slot == 3:
        return -1
    return ties.faces[place, 0 if slot == 1 or slot == 5 else 1]


@internal
def face_load(ties, body, bonds, displacement, half, i, slot):
    """Return what the tied face beside a link carries per area, along and across, by its weight; 0 without one [Pa].

    Args:
        ties: `Ties`, or None, which is known when this is compiled.
        body: a `Body` of one material.
        bonds: `Bonds`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        i: the automaton.
        slot: of the link.
    """
    if ties is None:
        return 0.0, 0.0
    row = _face_beside(ties, i, slot)
    if row < 0:
        return 0.0, 0.0
    own, weight = ties.slots[row], face_weight(bonds, ties, row)
    eps, gamma = tied_strains(body, bonds, ties, displacement, half, row)
    twice = 2.0 * body.shear * (1.0 + bonds.stiffness[i, own])
    pressing = body.lame * bond_dilation(body, bonds, displacement, half, i)
    return weight * (twice * (eps - bonds.plastic[i, own, 0]) + pressing), weight * (twice * (gamma - bonds.plastic[i, own, 1]))


@internal
def strain_face(ties, body, bonds, displacement, half, i, slot, along, across):
    """Give the tied face beside a link, which has a new weight, the strains at which it carries a load; see `face_load`."""
    if ties is not None:
        row = _face_beside(ties, i, slot)
        if row >= 0:
            own, weight = ties.slots[row], face_weight(bonds, ties, row)
            eps, gamma, _, _ = face_strains(body, ties, displacement, half, row)
            origin, twice = bonds.origin, 2.0 * body.shear * (1.0 + bonds.stiffness[i, own])
            # Without elastic strain of the face: the volumetric part of its traction, and what a strain adds.
            origin[i, own, 0], origin[i, own, 1] = eps - bonds.plastic[i, own, 0], gamma - bonds.plastic[i, own, 1]
            _, share = whole_face(body, body.kind[i])
            others = body.lame * bond_dilation(body, bonds, displacement, half, i)
            slope = body.lame * weight * share / condensation(body, bonds, i)
            origin[i, own, 0] -= (along / weight - others) / (twice + slope)
            origin[i, own, 1] -= across / (weight * twice)
