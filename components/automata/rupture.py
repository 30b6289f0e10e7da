"""Links that break: each becomes a contact and an event. Compiled at the first break of a run."""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined, jit
from .contact import FIRST, SECOND, SLOT, START, contact_part, contact_stiffness, separation
from .inelastic_links import bond_failure, bond_tractions, pair_energy, volume_energy
from .link_histories import opposite_slot
from .link_release import lower_weight
from .strain_division import bond_dilations, division_energy
from .volumetric_strain import bond_dilation


@jit
def break_bonds(medium, motion, scratch, judgement, numbers, contacts, count, events, known, tick):
    """Break the marked links: each becomes a contact and an event; there must be room for them.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`.
        scratch: a `Scratch`; its dilations are updated.
        judgement: a `Judgement`.
        numbers: of the links, for events, shape (n, slots / 2).
        contacts: `Contacts`, written from row `count` on.
        count: how many contacts there are.
        events: rows as `events.event_rows` says, written from row `known` on.
        known: how many events there are.
        tick: number of the step.

    Returns:
        How many contacts and events there are now.
    """
    body, ground, bonds, law = medium.body, medium.ground, medium.bonds, medium.law
    first, u, slots = count, motion.displacement, body.directions.shape[0]
    for i in range(body.kind.size):
        for slot in range(slots // 2):
            if judgement.mark[i, slot] == 0.0:
                continue
            _, limit, cause = bond_failure(body, bonds, law, u, scratch.half, scratch.dilation, judgement.stress, i, slot)
            j = np.int64(body.neighbours[i, slot])
            row = contacts.pairs[count]
            row[FIRST], row[SECOND], row[SLOT], row[START] = i, j, slot, tick
            if i > j:
                row[FIRST], row[SECOND], row[SLOT] = j, i, opposite_slot(slots, slot)
            contacts.slid[count] = 0.0
            contacts.rest[count] = rest_distance(body, ground, bonds, motion, scratch.half, scratch.dilation, i, slot)
            event = events[known]
            event[0], event[1], event[2] = tick + 1, cause, numbers[i, slot]
            event[3], event[4] = judgement.mark[i, slot], limit
            count, known = count + 1, known + 1
    for row in range(first, count):
        lower_weight(body, bonds, law, contacts, row, tick)
    _update_dilations(bonds.mixture.moduli, body, bonds, u, scratch, contacts, first, count)
    return count, known


@internal_inlined
def _update_dilations(moduli, body, bonds, displacement, scratch, contacts, first, count):
    """Compute the volumetric strains at both ends of the links of some contacts; of several materials those of all."""
    if moduli.ndim == 2:
        bond_dilations(body, bonds, displacement, scratch.half, scratch.dilation, 0, body.kind.size)
    else:
        for row in range(first, count):
            for end in (FIRST, SECOND):
                i = contacts.pairs[row, end]
                scratch.dilation[i] = bond_dilation(body, bonds, displacement, scratch.half, i)


@internal_inlined
def rest_distance(body, ground, bonds, motion, half, dilation, i, slot):
    """Return the distance at rest of the contact that a breaking link leaves behind [m].

    The contact takes over the pressure of the link, but no more than the overlap since the diameter, which an elastic link
    has, and no more energy than the link has with its part of the energies of both volumes: a link that has flowed together
    holds less of both. One that pulls leaves a contact without overlap.
    """
    # Kernels for int32, as which neighbours are kept, would be compiled once more.
    j, kind = np.int64(body.neighbours[i, slot]), body.kind[i]
    _, _, r = separation(ground, motion.displacement, i, j)
    normal, _, _, _ = bond_tractions(body, bonds, motion.displacement, half, dilation, i, slot)
    most = body.diameter - r
    if not (most > 0.0 and normal < 0.0):
        return min(body.diameter, r)
    stiffness = contact_stiffness(ground.normal, i, j) * contact_part(ground, i, j)
    energy = pair_energy(body, bonds, motion.displacement, half, i, slot)
    energy -= division_energy(bonds.mixture.moduli, body, bonds, motion.displacement, half, i, slot)
    energy += _part_of_volume(body, bonds, motion, half, i, slot)
    energy += _part_of_volume(body, bonds, motion, half, j, opposite_slot(body.directions.shape[0], slot))
    return r + min(most, -normal * body.face[kind, slot] / stiffness, np.sqrt(max(2.0 * energy / stiffness, 0.0)))


@internal
def _part_of_volume(body, bonds, motion, half, i, slot):
    """Return the part of the energy of a volume that belongs to one of its links, by its share in the strain [J]."""
    shares, kind = 0.0, body.kind[i]
    for other in range(body.directions.shape[0]):
        shares += bonds.weight[i, other] * body.share[kind, other]
    return volume_energy(body, bonds, motion.displacement, half, i) * body.share[kind, slot] / shares
