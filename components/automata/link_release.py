"""Release of broken links: each becomes a contact and an event, and its weight falls from 1 to 0 over several steps.

Each step records the energy that a change of weights takes from the link, from both volumes and from the contact.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined, jit
from .contacts import FIRST, SECOND, START, contact_link, contact_stiffnesses, link_weight, separation, write_link_value
from .energies import division_energy, link_energy, pair_energy, volume_energy
from .lattice import FACE, FIRST_SHARE, NORMAL, SECOND_SHARE

# Entries of `losses`, the dissipated energies; and the value of its last entry that requests a search in the next step.
FRACTURE, FRICTION, INELASTIC, DAMPING, LINKING, TRAVEL, LOSSES = 0, 1, 2, 3, 4, 5, 6
NEVER_FOUND = 1e300


@internal_inlined
def scheduled_weight(pairs, row, tick, release_ticks):
    """Return the weight of a link after the internal step `tick`: it falls after a break and rises after relinking."""
    start = pairs[row, START]
    if start >= 0:
        return max(0.0, 1.0 - (tick - start + 1) / release_ticks)
    return min(1.0, (tick + start + 2) / release_ticks)


@internal
def apply_mean_weights(layout, weight, contacts, tick, release_ticks):
    """Give links that are being released the mean of their weights before and after an internal step.

    The kick of a step belongs to both of its halves. Afterwards `apply_end_weights` writes the weight at the end of the step.

    Returns:
        Whether weights of other links rise: see `relinking.raise_link_weights`.
    """
    rising = False
    for row in range(contacts.used):
        before = link_weight(layout, weight, contacts.pairs, row)
        if 0.0 < before < 1.0:
            if contacts.pairs[row, START] >= 0:
                after = scheduled_weight(contacts.pairs, row, tick, release_ticks)
                write_link_value(weight, layout, contacts.pairs, row, 0.5 * (before + after))
            else:
                rising = True
    return rising


@internal
def apply_end_weights(medium, motion, links, contacts, tick, losses):
    """Give links that are being released their weights at the end of an internal step, and tally the released energy.

    The energy of one link depends on the weights of the other links at its ends. Each is computed with the mean weights of the
    others; the sum is then the total energy up to terms of third order in the change of a step. `links` has the strains of the
    present positions, `contacts` the present slip; see FRACTURE for `losses`.
    """
    layout, weight, pairs = medium.body.layout, medium.histories.weight, contacts.pairs
    for row in range(contacts.used):
        mean = link_weight(layout, weight, pairs, row)
        if 0.0 < mean < 1.0 and pairs[row, START] >= 0:
            after, released = scheduled_weight(pairs, row, tick, medium.law.release), 0.0
            for sign, value in ((1.0, 2.0 * mean - after), (-1.0, after)):
                write_link_value(weight, layout, pairs, row, value)
                released += sign * pair_energy(medium, motion, links, contacts, row)
            write_link_value(weight, layout, pairs, row, mean)
            losses[FRACTURE] += released
    for row in range(contacts.used):
        if 0.0 < link_weight(layout, weight, pairs, row) < 1.0:
            after = scheduled_weight(pairs, row, tick, medium.law.release)
            write_link_value(weight, layout, pairs, row, after)
            if after == 1.0:
                # The link is intact: the search before the next step removes its contact from the list.
                losses[TRAVEL] = NEVER_FOUND


@jit
def write_rest_distances(medium, motion, scratch, contacts, first_row):
    """Write the rest distances of the contacts that breaking links leave, from row `first_row` on [m].

    The contact takes over the pressure of the link, up to two limits: its overlap is at most that relative to the diameter, as
    in an elastic link, and its energy is at most the link's energy with its share of both volume energies. A link that has
    yielded in compression stores less of both. A link in tension leaves a contact without overlap. `scratch` has the strains
    and tractions at the present positions.
    """
    body, h, links = medium.body, medium.histories, scratch.links
    for row in range(first_row, contacts.used):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        q, p = contact_link(body.layout, contacts.pairs, row)
        _, _, r = separation(medium.contact_constants, body.layout.place, motion, i, j)
        most, normal = body.diameter - r, links[NORMAL, q, p]
        contacts.rest[row] = min(body.diameter, r)
        if most > 0.0 and normal < 0.0:
            stiffness, _ = contact_stiffnesses(medium.contact_constants, i, j)
            begins = body.layout.place[i] == p
            energy = link_energy(medium, links, q, p) - division_energy(medium.link_moduli, body, h, links, q, p)
            energy += _volume_energy_share(body, h, links, p, body.links[FIRST_SHARE, q, p])
            energy += _volume_energy_share(
                body, h, links, body.layout.place[j if begins else i], body.links[SECOND_SHARE, q, p]
            )
            face = body.links[FACE, q, p]
            contacts.rest[row] = r + min(most, -normal * face / stiffness, np.sqrt(max(2.0 * energy / stiffness, 0.0)))


@internal
def _volume_energy_share(body, h, links, p, share):
    """Return the part of the volume energy of automaton p that belongs to a link with this share in the volume strain [J]."""
    shares = 0.0
    for q in range(body.layout.offset.size):
        b = p - body.layout.offset[q]
        shares += h.weight[q, p] * body.links[FIRST_SHARE, q, p] + h.weight[q, b] * body.links[SECOND_SHARE, q, b]
    return volume_energy(body, h, links, p) * share / shares
