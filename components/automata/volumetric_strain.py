"""The volumetric strains of automata whose links may yield and break; see `inelastic_links`."""

from __future__ import annotations

from ..support.jit import internal, internal_inlined
from .link_histories import bond_strains, free_share
from .material_mixture import lame_of, shear_of
from .pair import mirrored_slots


@internal_inlined
def _free_shares(body, bonds, i):
    """Return the shares of the released faces of an automaton."""
    k, slots, free = body.kind[i], body.directions.shape[0], 0.0
    for group in range(slots // 2 - 1, -1, -1):
        a, b = mirrored_slots(slots, group)
        free += free_share(body, bonds, i, k, a) + free_share(body, bonds, i, k, b)
    return free


@internal_inlined
def _stiffening(body, bonds, i, free):
    """Return 1 + a of an automaton with these shares of released faces."""
    moduli = bonds.mixture.moduli
    return 1.0 + (body.missing[body.kind[i]] + free) * lame_of(moduli, i, body.lame) / (2.0 * shear_of(moduli, i, body.shear))


@internal_inlined
def condensation(body, bonds, i):
    """Return 1 + a of an automaton: what its free and released faces make of the volumetric strain."""
    return _stiffening(body, bonds, i, _free_shares(body, bonds, i))


@internal_inlined
def _link_strains(body, bonds, displacement, half, i):
    """Return the sum of the strains of the links of an automaton, by their shares."""
    k, slots = body.kind[i], body.directions.shape[0]
    total = 0.0
    for group in range(slots // 2 - 1, -1, -1):
        pair = 0.0
        for slot in mirrored_slots(slots, group):
            eps, _, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
            weight = bonds.weight[i, slot]
            # A released face keeps the strain that has flowed.
            strain = eps if weight == 1.0 else weight * eps + (1.0 - weight) * bonds.plastic[i, slot, 0]
            pair += body.share[k, slot] * strain
        total += pair
    return total


@internal_inlined
def bond_dilation(body, bonds, displacement, half, i):
    """Return the volumetric strain of an automaton, both halves of its links being strained alike."""
    return _link_strains(body, bonds, displacement, half, i) / condensation(body, bonds, i)


@internal
def uniform_dilations(body, bonds, displacement, half, dilation_out, begin, end):
    """Write the volumetric strains of automata from `begin` up to `end`, both halves of their links being strained alike.

    Args:
        body: a `Body`.
        bonds: `Bonds`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation_out: shape (n,).
        begin: first automaton.
        end: after the last one.
    """
    for i in range(begin, end):
        strain = _link_strains(body, bonds, displacement, half, i)
        dilation_out[i] = strain / _stiffening(body, bonds, i, _free_shares(body, bonds, i))
