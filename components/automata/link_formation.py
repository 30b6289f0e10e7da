"""Contacts that become links again: which ones, and their events. Compiled where a run has a law for it.

Specimens have one material here: see `parameters`.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal_inlined, jit
from .contact import (
    FIRST,
    SECOND,
    SLOT,
    START,
    contact_part,
    contact_stiffness,
    separation,
    sliding_speed,
)
from .link_histories import opposite_slot, pair_strains
from .link_release import LINKING, pair_and_volumes, put_weight, scheduled_weight
from .pair import turned
from .volumetric_strain import bond_dilation, condensation
from .zigzag_relinking import face_load, strain_face


@internal_inlined
def linking_pressure(medium, motion, half, contacts, row):
    """Return the pressure of a contact that may be linked by it, of others -1 [Pa].

    It was linked once and is released, it slides slowly enough, and its line of centres lies within 45 degrees of the axis
    that its link had and has.
    """
    body, ground = medium.body, medium.ground
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    if slot < 0 or medium.bonds.weight[i, slot] > 0.0:
        return -1.0
    x, y, r = separation(ground, motion.displacement, i, j)
    overlap = contacts.rest[row] - r
    if not overlap > 0.0 or r == 0.0:
        return -1.0
    eps, gamma, _, _ = pair_strains(body, motion.displacement, half, i, slot)
    if abs(gamma) > 1.0 + eps or abs(sliding_speed(motion, i, j, x / r, y / r, r)) > medium.law.linking[1]:
        return -1.0
    face = contact_stiffness(ground.tangential, i, j) * body.diameter / (2.0 * body.shear)
    return contact_stiffness(ground.normal, i, j) * overlap / face


@jit
def count_linkable(medium, motion, half, contacts, count):
    """Return how many contacts are linked again now; arguments as for `link_contacts`."""
    found = 0
    for row in range(count):
        if linking_pressure(medium, motion, half, contacts, row) >= medium.law.linking[0]:
            found += 1
    return found


@jit
def link_contacts(medium, motion, half, numbers, contacts, count, kind, events, known, tick):
    """Begin to link pairs that press hard enough and hardly slide; there must be room for their events.

    Args:
        medium: a `Medium`.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        numbers: of the links, for events, shape (n, slots / 2).
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        kind: number of the kind of events.
        events: rows as `events.EVENT_ROWS` says, written from row `known` on.
        known: how many events there are.
        tick: number of the step.

    Returns:
        How many events there are now.
    """
    slots = medium.body.directions.shape[0]
    for row in range(count):
        pressure = linking_pressure(medium, motion, half, contacts, row)
        if not pressure >= medium.law.linking[0]:
            continue
        i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
        number = numbers[i, slot] if slot < slots // 2 else numbers[j, opposite_slot(slots, slot)]
        contacts.pairs[row, START] = -1 - tick
        event = events[known]
        event[0], event[1], event[2], event[3], event[4] = tick + 1, kind, number, pressure, medium.law.linking[0]
        known += 1
    return known


@jit
def raise_weights(medium, motion, scratch, contacts, count, losses, tick):
    """Raise the weights of links that are made anew, and count the energy that this takes.

    In each step such a link gets the strains at which it carries what its contact carries: no motion in the meantime strains
    it, so that linking makes no energy.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`.
        scratch: a `Scratch`; its dilations are updated.
        contacts: `Contacts`.
        count: how many contacts there are.
        losses: see `link_release.FRACTURE`, updated in place.
        tick: number of the step.
    """
    body, ground, bonds, half = medium.body, medium.ground, medium.bonds, scratch.half
    for row in range(count):
        i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
        if slot < 0 or contacts.pairs[row, START] >= 0 or bonds.weight[i, slot] == 1.0:
            continue
        before, after = bonds.weight[i, slot], scheduled_weight(contacts.pairs, row, tick, medium.law.release)
        losses[LINKING] += pair_and_volumes(body, ground, bonds, motion, half, contacts, row)
        strain_link(body, ground, bonds, motion, half, contacts, row, after)
        losses[LINKING] -= pair_and_volumes(body, ground, bonds, motion, half, contacts, row)
        put_weight(body, bonds, contacts.pairs, row, 0.5 * (before + after))
        for one in (i, j):
            scratch.dilation[one] = bond_dilation(body, bonds, motion.displacement, half, one)


@internal_inlined
def strain_link(body, ground, bonds, motion, half, contacts, row, weight):
    """Give a link a weight, and the strains at which it carries what its contact would carry alone.

    Its history goes on: what is left of its stiffness, and the strains that have flowed, which its free faces kept. Where the
    link is softer than the contact it carries less, so that it has no more energy than the contact.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`, updated in place.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        row: of the contact.
        weight: of the link.
    """
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    back = opposite_slot(body.directions.shape[0], slot)
    twice = 2.0 * body.shear * (1.0 + bonds.stiffness[i, slot])
    eps, gamma, less, sine = pair_strains(body, motion.displacement, half, i, slot)
    nx, ny = turned(1.0, 0.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    x, y, r = separation(ground, motion.displacement, i, j)
    part, overlap = contact_part(ground, i, j), max(contacts.rest[row] - r, 0.0)
    slid = contacts.slid[row] if overlap > 0.0 else 0.0
    push = part * contact_stiffness(ground.normal, i, j) * overlap
    drag = part * contact_stiffness(ground.tangential, i, j) * slid
    fx, fy = (-push * x - drag * y) / r, (-push * y + drag * x) / r
    along, across = fx * nx + fy * ny, fy * nx - fx * ny
    # Without elastic strain of the link, and with its new weight: the volumetric part of its traction, and what a strain adds.
    for one, own in ((i, slot), (j, back)):
        bonds.origin[one, own, 0], bonds.origin[one, own, 1] = (
            eps - bonds.plastic[one, own, 0],
            gamma - bonds.plastic[one, own, 1],
        )
    u, ties = motion.displacement, bonds.ties
    first_along, first_across = face_load(ties, body, bonds, u, half, i, slot)
    second_along, second_across = face_load(ties, body, bonds, u, half, j, back)
    put_weight(body, bonds, contacts.pairs, row, weight)
    strain_face(ties, body, bonds, u, half, i, slot, first_along, first_across)
    strain_face(ties, body, bonds, u, half, j, back, second_along, second_across)
    area, others, slope = body.face[body.kind[i], slot], 0.0, 0.0
    for one, own in ((i, slot), (j, back)):
        others += 0.5 * body.lame * bond_dilation(body, bonds, motion.displacement, half, one)
        slope += 0.5 * body.lame * weight * body.share[body.kind[one], own] / condensation(body, bonds, one)
    has = push * overlap + drag * slid
    needs = body.diameter * (along * along / (area * (twice + slope)) + across * across / (area * twice))
    factor = np.sqrt(has / needs) if needs > has else 1.0
    for one, own in ((i, slot), (j, back)):
        bonds.origin[one, own, 0] -= (factor * along / area - others) / (twice + slope)
        bonds.origin[one, own, 1] -= factor * across / (area * twice)
