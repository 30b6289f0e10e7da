"""Links that break: each becomes a contact and an event, and its weight falls over several steps.

Each step counts the energy that a change of weights takes from the link, both volumes and the contact.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined, jit
from .contacts import FIRST, SECOND, SLOT, START, contact_energy, separation, stiffnesses
from .energies import division_energy, link_at, link_energy, pair_and_volumes, put, volume_energy
from .links import failure_of, pull_medium, strain_medium

# Places in a tally of losses, and the value of the last one that makes the next step find contacts.
FRACTURE, FRICTION, INELASTIC, DAMPING, LINKING, TRAVEL, LOSSES = 0, 1, 2, 3, 4, 5, 6
NEVER_FOUND = 1e300


@internal_inlined
def weight_of(medium, pairs, row):
    """Return the weight of the link of a contact; 0 where there never was one."""
    if pairs[row, SLOT] < 0:
        return 0.0
    q, p = link_at(medium.body.layout, pairs[row, FIRST], pairs[row, SECOND], pairs[row, SLOT])
    return medium.histories.weight[q, p]


@internal_inlined
def put_weight(medium, pairs, row, weight):
    """Write the weight of the link of a contact."""
    put(medium.histories.weight, medium.body.layout, pairs[row, FIRST], pairs[row, SECOND], pairs[row, SLOT], weight)


@internal_inlined
def scheduled_weight(pairs, row, tick, release):
    """Return the weight of a link after an internal step: falling since it broke, rising since it was made again."""
    start = pairs[row, START]
    if start >= 0:
        return max(0.0, 1.0 - (tick - start + 1) / release)
    return min(1.0, (tick + start + 2) / release)


@internal
def whole_energy(medium, motion, scratch, contacts, row):
    """Return the energy of a contact, of its link and of both volumes [J]."""
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    return pair_and_volumes(medium, scratch, i, j, slot) + contact_energy(medium, motion, contacts, row, 0.0)


@internal
def lower_weights(medium, contacts, tick):
    """Give links that are being released the mean of their weights before and after an internal step.

    The kick of a step belongs to both of its halves. `settle_weights` then writes the weight after it.

    Args:
        medium: a `links.Medium`; weights are updated.
        contacts: `contacts.Contacts`.
        tick: number of the internal step.

    Returns:
        Whether weights of others rise: see `welding.raise_weights`.
    """
    rising = False
    for row in range(contacts.used):
        weight = weight_of(medium, contacts.pairs, row)
        if 0.0 < weight < 1.0:
            if contacts.pairs[row, START] >= 0:
                after = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
                put_weight(medium, contacts.pairs, row, 0.5 * (weight + after))
            else:
                rising = True
    return rising


@internal
def settle_weights(medium, motion, scratch, contacts, tick, losses):
    """Give links whose weights change those after an internal step, and count the energy that releasing them takes.

    The energy that one of them takes depends on the weights of the others at its ends: each is counted while the others have
    the mean of theirs, with which the sum is that of all together, but for what is of third order in the change of a step.

    Args:
        medium: a `links.Medium`; weights are updated.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`, with the strains of the present positions.
        contacts: `contacts.Contacts`, which have slid up to now.
        tick: number of the internal step.
        losses: see FRACTURE, updated in place.
    """
    for row in range(contacts.used):
        if 0.0 < weight_of(medium, contacts.pairs, row) < 1.0 and contacts.pairs[row, START] >= 0:
            losses[FRACTURE] += _released_energy(medium, motion, scratch, contacts, row, tick)
    for row in range(contacts.used):
        if 0.0 < weight_of(medium, contacts.pairs, row) < 1.0:
            weight = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
            put_weight(medium, contacts.pairs, row, weight)
            if weight == 1.0:
                # It holds: before the next step its contact goes from the list.
                losses[TRAVEL] = NEVER_FOUND


@internal
def _released_energy(medium, motion, scratch, contacts, row, tick):
    """Return what releasing a link takes in an internal step, the weights being the means of this step [J]."""
    mean = weight_of(medium, contacts.pairs, row)
    after = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
    put_weight(medium, contacts.pairs, row, 2.0 * mean - after)
    released = whole_energy(medium, motion, scratch, contacts, row)
    put_weight(medium, contacts.pairs, row, after)
    released -= whole_energy(medium, motion, scratch, contacts, row)
    put_weight(medium, contacts.pairs, row, mean)
    return released


@jit
def break_links(medium, motion, scratch, pairs, numbers, contacts, events, tick):
    """Break the links whose criterion is met: each becomes a contact and an event; there must be room for them.

    Args:
        medium: a `links.Medium`; weights are updated.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`, with strains and stresses of the present positions.
        pairs: see `packing.Packing.pairs`, shape (links, 3).
        numbers: of the links in these, shape (directions, m).
        contacts: `contacts.Contacts`, written from row `used` on.
        events: rows as `events.event_rows` says, one for each link that breaks.
        tick: number of the step.

    Returns:
        How many links broke.
    """
    broken, layout = 0, medium.body.layout
    for i in range(layout.place.size):
        p = layout.place[i]
        for q in range(layout.offset.size):
            if medium.histories.weight[q, p] != 1.0:
                continue
            value, limit, cause = failure_of(medium, scratch, q, p)
            if not value >= limit:
                continue
            at, number = contacts.used + broken, numbers[q, p]
            j, row = pairs[number, 1], contacts.pairs[at]
            row[FIRST], row[SECOND], row[SLOT], row[START] = i, j, q, tick
            if i > j:
                row[FIRST], row[SECOND], row[SLOT] = j, i, q + layout.offset.size
            contacts.slid[at] = 0.0
            contacts.rest[at] = _rest_distance(medium, motion, scratch, i, j, q)
            event = events[broken]
            event[0], event[1], event[2], event[3], event[4] = tick + 1, cause, number, value, limit
            broken += 1
    if broken:
        _lower_first(medium, contacts, broken, tick)
        strain_medium(medium, motion, scratch)
        pull_medium(medium, scratch)
    return broken


@internal
def _lower_first(medium, contacts, broken, tick):
    """Give links that have just broken the mean weight of their first step."""
    for row in range(contacts.used, contacts.used + broken):
        after = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
        put_weight(medium, contacts.pairs, row, 0.5 * (1.0 + after))


@internal
def _rest_distance(medium, motion, scratch, i, j, q):
    """Return the distance at rest of the contact that a breaking link leaves behind [m].

    The contact takes over the pressure of the link, but no more than the overlap since the diameter, which an elastic link
    has, and no more energy than the link has with its part of the energies of both volumes: a link that has flowed together
    holds less of both. One that pulls leaves a contact without overlap.
    """
    body = medium.body
    p, end = body.layout.place[i], body.layout.place[j]
    _, _, r = separation(medium, motion, i, j)
    normal = medium.tractions.normal[q, p]
    most = body.diameter - r
    if not (most > 0.0 and normal < 0.0):
        return min(body.diameter, r)
    stiffness, _ = stiffnesses(medium.ground, i, j)
    energy = link_energy(medium, scratch, q, p) - division_energy(medium.mixture, medium, scratch, q, p)
    energy += _part_of_volume(medium, scratch, p, body.first_share[q, p])
    energy += _part_of_volume(medium, scratch, end, body.second_share[q, p])
    return r + min(most, -normal * body.face[q, p] / stiffness, np.sqrt(max(2.0 * energy / stiffness, 0.0)))


@internal
def _part_of_volume(medium, scratch, p, share):
    """Return the part of the energy of a volume that belongs to a link with a share in its strain [J]."""
    body, weight, shares = medium.body, medium.histories.weight, 0.0
    for q in range(body.layout.offset.size):
        o = body.layout.offset[q]
        shares += weight[q, p] * body.first_share[q, p] + weight[q, p - o] * body.second_share[q, p - o]
    return volume_energy(medium, scratch, p) * share / shares
