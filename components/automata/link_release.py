"""The release of broken links: their weights fall over several steps, and rise after relinking; and the energy that this takes.

What a change of weights takes of the energy of the link, of both volumes and of the contact is counted in the step itself.
"""

from __future__ import annotations

from ..support.jit import internal, internal_inlined
from .contact import FIRST, SECOND, SLOT, START, contact_energy
from .inelastic_links import pair_energy, volume_energy
from .link_histories import opposite_slot
from .strain_division import divisions_around

# Places in a tally of losses, and what stands for "contacts have to be found anew" in the last one.
FRACTURE, FRICTION, INELASTIC, DAMPING, LINKING, TRAVEL, LOSSES = 0, 1, 2, 3, 4, 5, 6
NEVER_FOUND = 1e300


@internal_inlined
def put_weight(body, bonds, pairs, row, weight):
    """Write the weight of a link at both of its ends."""
    i, j, slot = pairs[row, FIRST], pairs[row, SECOND], pairs[row, SLOT]
    bonds.weight[i, slot] = weight
    bonds.weight[j, opposite_slot(body.directions.shape[0], slot)] = weight


@internal_inlined
def scheduled_weight(pairs, row, tick, release):
    """Return the weight of a link after an internal step: falling since it broke, rising since it was made anew."""
    start = pairs[row, START]
    if start >= 0:
        return max(0.0, 1.0 - (tick - start + 1) / release)
    return min(1.0, (tick + start + 2) / release)


@internal
def pair_and_volumes(body, ground, bonds, motion, half, contacts, row):
    """Return the energy of a contact, of its link, of both volumes, less that of divisions [J]."""
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    energy = volume_energy(body, bonds, motion.displacement, half, i) + volume_energy(body, bonds, motion.displacement, half, j)
    energy += bonds.weight[i, slot] * pair_energy(body, bonds, motion.displacement, half, i, slot)
    energy -= divisions_around(bonds.mixture.moduli, body, bonds, motion.displacement, half, i, j)
    return energy + contact_energy(ground, bonds, motion, contacts, row, 0.0)


@internal_inlined
def lower_weight(body, bonds, law, contacts, row, tick):
    """Give the broken link of a contact the mean of its weights before and after an internal step.

    The kick of a step belongs to both of its halves. `settle_weights` then writes the weight after it.
    """
    before = bonds.weight[contacts.pairs[row, FIRST], contacts.pairs[row, SLOT]]
    put_weight(body, bonds, contacts.pairs, row, 0.5 * (before + scheduled_weight(contacts.pairs, row, tick, law.release)))


@internal
def lower_weights(body, bonds, law, contacts, count, tick):
    """Lower the weights of all links that are being released.

    Args:
        body: a `Body`.
        bonds: `Bonds`, updated in place.
        law: a `Law`.
        contacts: `Contacts`.
        count: how many contacts there are.
        tick: number of the internal step.

    Returns:
        Whether weights of others rise: see `link_formation.raise_weights`.
    """
    rising = False
    for row in range(count):
        slot = contacts.pairs[row, SLOT]
        if slot >= 0 and 0.0 < bonds.weight[contacts.pairs[row, FIRST], slot] < 1.0:
            if contacts.pairs[row, START] >= 0:
                lower_weight(body, bonds, law, contacts, row, tick)
            else:
                rising = True
    return rising


@internal
def settle_weights(body, ground, bonds, law, motion, half, contacts, count, tick, losses):
    """Give links whose weights change those after an internal step, and count the energy that releasing them takes.

    What one of them takes depends on the weights of the others at its ends: each is counted while the others have the mean
    of theirs, with which the sum is that of all together, but for what is of third order in the change of a step.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`, updated in place.
        law: a `Law`.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`, which have slid up to now.
        count: how many contacts there are.
        tick: number of the internal step.
        losses: see FRACTURE, updated in place.
    """
    for row in range(count):
        slot = contacts.pairs[row, SLOT]
        if slot >= 0 and 0.0 < bonds.weight[contacts.pairs[row, FIRST], slot] < 1.0 and contacts.pairs[row, START] >= 0:
            losses[FRACTURE] += _released_energy(body, ground, bonds, law, motion, half, contacts, row, tick)
    for row in range(count):
        slot = contacts.pairs[row, SLOT]
        if slot >= 0 and 0.0 < bonds.weight[contacts.pairs[row, FIRST], slot] < 1.0:
            weight = scheduled_weight(contacts.pairs, row, tick, law.release)
            put_weight(body, bonds, contacts.pairs, row, weight)
            if weight == 1.0:
                # It holds: before the next step its contact goes from the list.
                losses[TRAVEL] = NEVER_FOUND


@internal
def _released_energy(body, ground, bonds, law, motion, half, contacts, row, tick):
    """Return what releasing a link takes in an internal step, the weights being the means of this step [J]."""
    mean = bonds.weight[contacts.pairs[row, FIRST], contacts.pairs[row, SLOT]]
    after = scheduled_weight(contacts.pairs, row, tick, law.release)
    put_weight(body, bonds, contacts.pairs, row, 2.0 * mean - after)
    released = pair_and_volumes(body, ground, bonds, motion, half, contacts, row)
    put_weight(body, bonds, contacts.pairs, row, after)
    released -= pair_and_volumes(body, ground, bonds, motion, half, contacts, row)
    put_weight(body, bonds, contacts.pairs, row, mean)
    return released
