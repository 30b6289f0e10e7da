"""Contacts that become links again: which ones, and their events. Compiled where a run has a law for it.

Specimens have one material here: see `parameters`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.jit import internal, internal_inlined, jit
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
from .drift_work import Neighbourhood, drift_work, gather_members
from .link_histories import opposite_slot, pair_strains
from .link_release import LINKING, pair_and_volumes, put_weight, scheduled_weight
from .pair import turned
from .volumetric_strain import bond_dilation, condensation

# Part of the energy that is rounding.
_ROUNDING = 1e-9


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
        events: rows as `events.event_rows` says, written from row `known` on.
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


@internal_inlined
def _copy(source, from_row, target, to_row):
    for slot in range(source.shape[1]):
        target[to_row, slot, 0], target[to_row, slot, 1] = source[from_row, slot, 0], source[from_row, slot, 1]


@internal_inlined
def _neutral_strain(before, at, after, unit):
    """Return the strain nearest to 0 at which a parabola is 0, from its values at -unit, 0 and unit; NaN beyond these."""
    slope, curvature = 0.5 * (after - before) / unit, (0.5 * (after + before) - at) / (unit * unit)
    under = slope * slope - 4.0 * curvature * at
    if not (under >= 0.0 and slope != 0.0):
        return np.nan
    root = np.sqrt(under)
    strain = -2.0 * at / (slope + (root if slope > 0.0 else -root))
    return strain if abs(strain) <= unit else np.nan


class _Pair(NamedTuple):
    """A pair whose link is being made, and what it was before the step.

    Attributes:
        row: of its contact.
        before: weight of the link before the step.
        after: weight after it; the kick is made with the mean of both.
        near: its `drift_work.Neighbourhood`.
        members: how many automata are in that.
        time: of the drift before the step [s].
        energy: `pair_and_volumes` before [J].
        work: `drift_work` before [J].
    """

    row: int
    before: float
    after: float
    near: Neighbourhood
    members: int
    time: float
    energy: float
    work: float


@internal
def _raise_weight(medium, motion, half, contacts, pair, part, more):
    """Raise the weight of a link, strain it as `strain_link` does, and return the energy that this takes [J].

    The strains of the drift before are let go, so that the kick does not feel them: what the forces would have done in it more
    than they do is no loss.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`; its velocities are those of the drift before.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        pair: a `_Pair`.
        part: see `strain_link`.
        more: see there.
    """
    body, ground, bonds, row = medium.body, medium.ground, medium.bonds, pair.row
    strain_link(body, ground, bonds, motion, half, contacts, row, pair.after, part, more)
    taken = pair.energy - pair_and_volumes(body, ground, bonds, motion, half, contacts, row)
    taken += 0.5 * (pair.work + drift_work(medium, motion, half, contacts, row, pair.near, pair.members, pair.time))
    put_weight(body, bonds, contacts.pairs, row, 0.5 * (pair.before + pair.after))
    return taken - drift_work(medium, motion, half, contacts, row, pair.near, pair.members, pair.time)


@internal
def _put_back(medium, contacts, pair):
    """Give the link of a pair the weight and the strains that it had before the step."""
    origin, origins = medium.bonds.origin, pair.near.origins
    _copy(origins, 0, origin, contacts.pairs[pair.row, FIRST])
    _copy(origins, 1, origin, contacts.pairs[pair.row, SECOND])
    put_weight(medium.body, medium.bonds, contacts.pairs, pair.row, pair.before)


@internal
def _raise_neutrally(medium, motion, half, contacts, pair, taken):
    """Raise the weight of a link so that this takes no energy, or else as little as there is; return what it takes [J].

    Args:
        medium: see `_raise_weight`, as the next ones.
        motion: see there.
        half: see there.
        contacts: see there.
        pair: see there.
        taken: what it would take with the strains of the contact [J].
    """
    _, _, r = separation(medium.ground, motion.displacement, contacts.pairs[pair.row, FIRST], contacts.pairs[pair.row, SECOND])
    unit, more = max(contacts.rest[pair.row] - r, 0.0) / medium.body.diameter, np.nan
    if unit > 0.0:
        # Less strain and more tell with how much it takes nothing.
        pressed_more = _raise_weight(medium, motion, half, contacts, pair, 1.0, -unit)
        _put_back(medium, contacts, pair)
        pressed_less = _raise_weight(medium, motion, half, contacts, pair, 1.0, unit)
        _put_back(medium, contacts, pair)
        more = _neutral_strain(pressed_more, taken, pressed_less, unit)
    if more == more:
        return _raise_weight(medium, motion, half, contacts, pair, 1.0, more)
    if taken < 0.0 < pair.before:
        contacts.pairs[pair.row, START] -= 1
        return 0.0
    # One that has not begun cannot wait: where it would make energy it begins without strains.
    return _raise_weight(medium, motion, half, contacts, pair, 0.0 if taken < 0.0 else 1.0, 0.0)


@jit
def raise_weights(medium, motion, scratch, contacts, count, losses, tick, time, near):
    """Raise the weights of links that are made anew, and count the energy that this takes.

    In each step such a link gets the strains at which it carries what its contact carries, and is pressed a little more or
    less, so that this takes no energy: as links are made, the volumes of both automata become stiffer. Where no such strain is
    near, it may take energy; it never makes any, but waits for the next step.

    Args:
        medium: a `Medium`; its bonds are updated in place.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        scratch: a `Scratch`; its dilations are updated.
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        losses: see `link_release.FRACTURE`, updated in place.
        tick: number of the step.
        time: since the forces were computed last [s].
        near: a `drift_work.Neighbourhood`, overwritten.
    """
    body, bonds, half = medium.body, medium.bonds, scratch.half
    for row in range(count):
        i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
        if slot < 0 or contacts.pairs[row, START] >= 0 or bonds.weight[i, slot] == 1.0:
            continue
        before, after = bonds.weight[i, slot], scheduled_weight(contacts.pairs, row, tick, medium.law.release)
        members = gather_members(body, motion, half, contacts, row, near)
        energy = pair_and_volumes(body, medium.ground, bonds, motion, half, contacts, row)
        work = drift_work(medium, motion, half, contacts, row, near, members, time)
        _copy(bonds.origin, i, near.origins, 0)
        _copy(bonds.origin, j, near.origins, 1)
        pair = _Pair(row, before, after, near, members, time, energy, work)
        taken = _raise_weight(medium, motion, half, contacts, pair, 1.0, 0.0)
        if abs(taken) > _ROUNDING * energy:
            _put_back(medium, contacts, pair)
            taken = _raise_neutrally(medium, motion, half, contacts, pair, taken)
        losses[LINKING] += taken
        for one in (i, j):
            scratch.dilation[one] = bond_dilation(body, bonds, motion.displacement, half, one)


@internal_inlined
def strain_link(body, ground, bonds, motion, half, contacts, row, weight, part, more):
    """Give a link a weight, and part of the strains at which it carries what its contact would carry alone, and one more.

    Its history goes on: what is left of its stiffness, and the strains that have flowed, which its free faces kept.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`, updated in place.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        row: of the contact.
        weight: of the link.
        part: of these strains.
        more: strain along the link beyond that.
    """
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    back = opposite_slot(body.directions.shape[0], slot)
    twice = 2.0 * body.shear * (1.0 + bonds.stiffness[i, slot])
    eps, gamma, less, sine = pair_strains(body, motion.displacement, half, i, slot)
    nx, ny = turned(1.0, 0.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    x, y, r = separation(ground, motion.displacement, i, j)
    stiffness_part, overlap = contact_part(ground, i, j), max(contacts.rest[row] - r, 0.0)
    slid = contacts.slid[row] if overlap > 0.0 else 0.0
    push = stiffness_part * contact_stiffness(ground.normal, i, j) * overlap
    drag = stiffness_part * contact_stiffness(ground.tangential, i, j) * slid
    fx, fy = (-push * x - drag * y) / r, (-push * y + drag * x) / r
    along, across = fx * nx + fy * ny, fy * nx - fx * ny
    # Without elastic strain of the link, and with its new weight: the volumetric part of its traction, and what a strain adds.
    for one, own in ((i, slot), (j, back)):
        bonds.origin[one, own, 0], bonds.origin[one, own, 1] = (
            eps - bonds.plastic[one, own, 0],
            gamma - bonds.plastic[one, own, 1],
        )
    put_weight(body, bonds, contacts.pairs, row, weight)
    area, others, slope = body.face[body.kind[i], slot], 0.0, 0.0
    for one, own in ((i, slot), (j, back)):
        others += 0.5 * body.lame * bond_dilation(body, bonds, motion.displacement, half, one)
        slope += 0.5 * body.lame * weight * body.share[body.kind[one], own] / condensation(body, bonds, one)
    for one, own in ((i, slot), (j, back)):
        bonds.origin[one, own, 0] -= part * (along / area - others) / (twice + slope) + more
        bonds.origin[one, own, 1] -= part * across / (area * twice)
