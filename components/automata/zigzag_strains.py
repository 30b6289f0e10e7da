"""Volumetric strains by tied faces, and by rows beside a zigzag, whose links may yield and break; see `zigzag_faces`.

A tied face has the histories of its slot, which has no neighbour. It goes with the links of its automaton to the two that carry
it: with each of them half of it is released, so its weight is the mean of theirs. It carries no event of its own.

A pair of a row at a corner strains the volumes of both by its shear, as in `zigzag_faces`; with its weight w, of the left one

    V_i theta_i  gets  -s (D^2 / 4) (w gamma + (1 - w) gamma_p).

Once it is released its face carries no shear either. Of the strains of a free face that make the energy least, the shear adds
three times as much to a as the stretch does: (D^2 / 4)^2 / (V_i c)^2 = 3 for half a face.
"""

from __future__ import annotations

from ..support.jit import internal_inlined
from .link_histories import free_share, origin_of
from .zigzag_faces import face_strains, row_moment, row_strains, whole_face

# What the shear of a released pair of a row adds to the shares of free faces, in shares of its face.
_SHEAR_SHARE = 3.0


@internal_inlined
def face_weight(bonds, ties, row):
    """Return the weight of a tied face: the mean of those of the two links beside it."""
    i, slot = ties.automata[row], ties.slots[row]
    before, after = (1, 5) if slot == 0 else (2, 4)
    return 0.5 * (bonds.weight[i, before] + bonds.weight[i, after])


@internal_inlined
def tied_strains(body, bonds, ties, displacement, half, row):
    """Return the strains of a tied face from those on that it was made with."""
    eps, gamma, _, _ = face_strains(body, ties, displacement, half, row)
    along, across = origin_of(bonds.origin, ties.automata[row], ties.slots[row])
    return eps - along, gamma - across


@internal_inlined
def _face_strain(body, bonds, ties, displacement, half, row):
    """Return the strain along a tied face that counts in the volume: a released part keeps the strain that has flowed."""
    eps, _ = tied_strains(body, bonds, ties, displacement, half, row)
    weight, plastic = face_weight(bonds, ties, row), bonds.plastic[ties.automata[row], ties.slots[row], 0]
    return eps if weight == 1.0 else weight * eps + (1.0 - weight) * plastic


@internal_inlined
def _row_shear(body, bonds, ties, displacement, half, row):
    """Return the shear of a pair of a row that counts in both volumes, times +-D^2 / 4 and the thickness."""
    _, gamma, _, _ = row_strains(body, ties, displacement, half, row)
    _, across = origin_of(bonds.origin, ties.rows[row, 0], 0)
    gamma -= across
    weight, plastic = bonds.weight[ties.rows[row, 0], 0], bonds.plastic[ties.rows[row, 0], 0, 1]
    shear = gamma if weight == 1.0 else weight * gamma + (1.0 - weight) * plastic
    return row_moment(body, ties, row) * shear


@internal_inlined
def add_tied_strains(ties, body, bonds, displacement, half, i, strain):
    """Return the sum of the strains of the links of an automaton, by their shares, with those of tied faces and of rows.

    Args:
        ties: `Ties`, or None, which is known when this is compiled.
        body: a `Body`.
        bonds: `Bonds`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        i: the automaton.
        strain: the sum of those of its links.
    """
    if ties is None:
        return strain
    place, k = ties.place[i], body.kind[i]
    if place < 0:
        return strain
    # Sums of both sides first: the bits are those of the mirrored specimen.
    _, share = whole_face(body, k)
    stretch, shear = 0.0, 0.0
    for side in range(2):
        face, pair = ties.faces[place, side], ties.pairs[place, side]
        if face >= 0:
            stretch += share * _face_strain(body, bonds, ties, displacement, half, face)
        if pair >= 0:
            # Side 0 is the pair with the right neighbour.
            sign = -1.0 if side == 0 else 1.0
            shear += sign * _row_shear(body, bonds, ties, displacement, half, pair)
    return strain + (stretch + shear / body.volume[k])


@internal_inlined
def tied_shares(ties, body, bonds, i):
    """Return the shares of the tied faces of an automaton that hold, and those of its released faces and pairs of rows.

    Args:
        ties: `Ties`, or None, which is known when this is compiled.
        body: a `Body`.
        bonds: `Bonds`.
        i: the automaton.
    """
    if ties is None:
        return 0.0, 0.0
    place, k = ties.place[i], body.kind[i]
    if place < 0:
        return 0.0, 0.0
    _, share = whole_face(body, k)
    held, faces, pairs = 0.0, 0.0, 0.0
    for side in range(2):
        row = ties.faces[place, side]
        if row >= 0:
            weight = face_weight(bonds, ties, row)
            held += weight * share
            faces += (1.0 - weight) * share / (1.0 + bonds.stiffness[i, ties.slots[row]])
        if ties.pairs[place, side] >= 0:
            pairs += _SHEAR_SHARE * free_share(body, bonds, i, k, 3 * side)
    return held, faces + pairs
