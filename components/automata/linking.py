"""Broken pairs that are linked again: a contact becomes a link and an event. Compiled where a run has a law for it."""

from __future__ import annotations

import numpy as np

from ..support.jit import inlined, jit
from .bonds import bond_dilation, condensation, opposite_slot, pair_strains
from .contact import FIRST, SECOND, SLOT, START, contact_part, separation, sliding_speed
from .pair import turned
from .release import change_weight


@inlined
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
    face = ground.tangential * body.diameter / (2.0 * body.shear)
    return ground.normal * overlap / face


@jit
def count_linkable(medium, motion, half, contacts, count):
    """Return how many contacts are linked again now; arguments as for `link_contacts`."""
    found = 0
    for row in range(count):
        if linking_pressure(medium, motion, half, contacts, row) >= medium.law.linking[0]:
            found += 1
    return found


@jit
def link_contacts(medium, motion, scratch, numbers, contacts, count, kind, events, known, losses, tick):
    """Link pairs that press hard enough and hardly slide; there must be room for their events.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`.
        scratch: a `Scratch`; its dilations are updated.
        numbers: of the links, for events, shape (n, slots / 2).
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        kind: number of the kind of events.
        events: rows as `snapshot.EVENT_ROWS` says, written from row `known` on.
        known: how many events there are.
        losses: see `release.FRACTURE`, updated in place.
        tick: number of the step.

    Returns:
        How many events there are now.
    """
    body, ground, bonds, law = medium.body, medium.ground, medium.bonds, medium.law
    slots, half = body.directions.shape[0], scratch.half
    for row in range(count):
        pressure = linking_pressure(medium, motion, half, contacts, row)
        if not pressure >= law.linking[0]:
            continue
        i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
        number = numbers[i, slot] if slot < slots // 2 else numbers[j, opposite_slot(slots, slot)]
        contacts.pairs[row, START] = -1 - tick
        make_link(body, ground, bonds, motion, half, scratch.dilation, contacts, row)
        change_weight(body, ground, bonds, law, motion, half, contacts, row, tick, losses)
        for one in (i, j):
            scratch.dilation[one] = bond_dilation(body, bonds, motion.displacement, half, one)
        event = events[known]
        event[0], event[1], event[2], event[3], event[4] = tick + 1, kind, number, pressure, law.linking[0]
        known += 1
    return known


@jit
def make_link(body, ground, bonds, motion, half, dilation, contacts, row):
    """Make the link of a contact anew, of weight 0 still: the two strains of it carry what the contact carries.

    Where the link is stiffer or softer than the contact it carries less, so that it has no more energy than the contact.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`, updated in place.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bonds.bond_dilations`, shape (n,).
        contacts: `Contacts`.
        row: of the contact, which presses.
    """
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    back, twice = opposite_slot(body.directions.shape[0], slot), 2.0 * body.shear
    eps, gamma, less, sine = pair_strains(body, motion.displacement, half, i, slot)
    nx, ny = turned(1.0, 0.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    x, y, r = separation(ground, motion.displacement, i, j)
    part, overlap = contact_part(ground, i, j), contacts.rest[row] - r
    push, drag = part * ground.normal * overlap, part * ground.tangential * contacts.slid[row]
    fx, fy = (-push * x - drag * y) / r, (-push * y + drag * x) / r
    along, across = fx * nx + fy * ny, fy * nx - fx * ny
    # The volumetric strains of both automata for a strain along the link: others + slope x strain.
    area, others, slope = body.face[body.kind[i], slot], 0.0, 0.0
    for one, own in ((i, slot), (j, back)):
        share, whole = body.share[body.kind[one], own], condensation(body, bonds, one)
        held = whole - share * body.lame / twice
        others += 0.5 * body.lame * dilation[one] * whole / held
        slope += 0.5 * body.lame * share / held
    has = push * overlap + drag * contacts.slid[row]
    needs = body.diameter * (along * along / (area * (twice + slope)) + across * across / (area * twice))
    factor = min(1.0, np.sqrt(has / needs))
    strain = (factor * along / area - others) / (twice + slope)
    for one, own in ((i, slot), (j, back)):
        bonds.origin[one, own, 0], bonds.origin[one, own, 1] = eps - strain, gamma - factor * across / (area * twice)
        bonds.plastic[one, own, 0] = bonds.plastic[one, own, 1] = 0.0
        bonds.stiffness[one, own] = bonds.inelastic[one, own] = 0.0
