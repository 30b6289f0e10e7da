"""Compute the energy of a single link, volume or contact, from the strains in the scratch; for the symbols see `links`."""

from __future__ import annotations

from ..support.dispatch import dispatch_by_class
from ..support.jit import internal, internal_inlined, jit
from .contacts import FIRST, SECOND, contact_energy, contact_link
from .lattice import EPS, FACE, FIRST_SHARE, GAMMA, LAME, MISSING, SECOND_SHARE, SHEAR, VOLUME
from .links import ACROSS, ALONG, MixedModuli, UniformModuli


@internal
def condensation_factor(body, h, p):
    """Return the factor 1 + a of an automaton; free and released faces divide its volume strain by it; `h` are `Histories`."""
    free, shares = body.cells[MISSING, p], body.links
    for q in range(body.layout.offset.size):
        # A released face keeps the remaining stiffness fraction g of its link.
        b = p - body.layout.offset[q]
        free += (1.0 - h.weight[q, p]) * shares[FIRST_SHARE, q, p] / (1.0 + h.stiffness[q, p])
        free += (1.0 - h.weight[q, b]) * shares[SECOND_SHARE, q, b] / (1.0 + h.stiffness[q, b])
    return 1.0 + free * body.cells[LAME, p] / (2.0 * body.cells[SHEAR, p])


@internal_inlined
def _counted_link_strain(h, links, q, p):
    return h.weight[q, p] * (links[EPS, q, p] - h.origin_eps[q, p]) + (1.0 - h.weight[q, p]) * h.plastic_eps[q, p]


@internal
def dilation(body, h, links, p):
    """Return the volume strain of automaton p before the strains of links between two materials are divided."""
    total = 0.0
    for q in range(body.layout.offset.size - 1, -1, -1):
        b = p - body.layout.offset[q]
        total += body.links[FIRST_SHARE, q, p] * _counted_link_strain(h, links, q, p)
        total += body.links[SECOND_SHARE, q, b] * _counted_link_strain(h, links, q, b)
    return total / condensation_factor(body, h, p)


@internal
def link_energy(medium, links, q, p):
    """Return the energy of link q at p for a weight of 1, without the energy of volumes [J]."""
    body, h, moduli = medium.body, medium.histories, medium.link_moduli.moduli
    eps = (links[EPS, q, p] - h.origin_eps[q, p]) - h.plastic_eps[q, p]
    gamma = (links[GAMMA, q, p] - h.origin_gamma[q, p]) - h.plastic_gamma[q, p]
    stiffness = moduli[ALONG, q, p] * (eps * eps) + moduli[ACROSS, q, p] * (gamma * gamma)
    return 0.5 * body.links[FACE, q, p] * body.diameter * (1.0 + h.stiffness[q, p]) * stiffness


@internal
def volume_energy(body, h, links, p):
    """Return the energy of the volume strain of automaton p [J]."""
    theta = dilation(body, h, links, p)
    return 0.5 * body.cells[VOLUME, p] * body.cells[LAME, p] * condensation_factor(body, h, p) * theta * theta


@dispatch_by_class
def division_energy(link_moduli, body, h, links, q, p):
    """Return how much the division of a link's strain between two materials lowers its energy, for a weight of 1 [J]."""


@division_energy.register(UniformModuli)
def _no_division_energy(link_moduli, body, h, links, q, p):
    return 0.0


@division_energy.register(MixedModuli)
def _division_energy(link_moduli, body, h, links, q, p):
    compliance, shear, lame = link_moduli.compliance[q, p], body.cells[SHEAR], body.cells[LAME]
    if compliance == 0.0:
        return 0.0
    j = p + body.layout.offset[q]
    theta, other = dilation(body, h, links, p), dilation(body, h, links, _source_place(body.layout.ghosts, j))
    eps = links[EPS, q, p] - h.origin_eps[q, p]
    stress = (shear[p] - shear[j]) * eps + 0.5 * (lame[p] * theta - lame[j] * other)
    return 0.5 * body.links[FACE, q, p] * body.diameter * compliance * stress * stress


@dispatch_by_class
def neighbour_division_energy(link_moduli, body, h, links, ends, link):
    """Return how much the divisions of strain lower the energies of all links of two neighbours [J].

    `ends` are the places of the two automata; `link` is the direction of their link, and where it begins.
    """


@neighbour_division_energy.register(UniformModuli)
def _no_neighbour_division_energy(link_moduli, body, h, links, ends, link):
    return 0.0


@neighbour_division_energy.register(MixedModuli)
def _neighbour_division_energy(link_moduli, body, h, links, ends, link):
    # The link between the two was counted at both ends; subtract it once.
    total = -_weighted_division_energy(link_moduli, body, h, links, link[0], link[1])
    for end in ends:
        for q in range(body.layout.offset.size):
            total += _weighted_division_energy(link_moduli, body, h, links, q, end)
            total += _weighted_division_energy(link_moduli, body, h, links, q, end - body.layout.offset[q])
    return total


@internal
def _weighted_division_energy(link_moduli, body, h, links, q, p):
    return h.weight[q, p] * division_energy(link_moduli, body, h, links, q, _source_place(body.layout.ghosts, p))


@internal
def _source_place(ghosts, p):
    """Return the index of the automaton that a ghost copies; for any other index the index itself."""
    for row in range(ghosts.shape[0]):
        if ghosts[row, 0] == p:
            return ghosts[row, 1]
    return p


@jit
def stored_energies(medium, motion, links, contacts, slip_time):
    """Return the energy of links and volumes, and the energy of contacts [J]; `links` are those of a `lattice.Scratch`.

    `slip_time` is the time for which contacts have slid since `slid` was recorded [s].
    """
    total, of_contacts, body, h = 0.0, 0.0, medium.body, medium.histories
    for i in range(body.layout.place.size):
        p = body.layout.place[i]
        total += volume_energy(body, h, links, p)
        for q in range(body.layout.offset.size):
            weight = h.weight[q, p]
            if weight > 0.0:
                total += weight * (link_energy(medium, links, q, p) - division_energy(medium.link_moduli, body, h, links, q, p))
    for row in range(contacts.used):
        of_contacts += contact_energy(medium, motion, contacts, row, slip_time)
    return total, of_contacts


@internal
def pair_energy(medium, motion, links, contacts, row):
    """Return the energy of the pair of a contact [J]: contact, link, and both volumes, lowered by the strain divisions."""
    body, h = medium.body, medium.histories
    i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
    first, second = body.layout.place[i], body.layout.place[j]
    q, p = contact_link(body.layout, contacts.pairs, row)
    energy = volume_energy(body, h, links, first) + volume_energy(body, h, links, second)
    energy += h.weight[q, p] * link_energy(medium, links, q, p)
    energy -= neighbour_division_energy(medium.link_moduli, body, h, links, (first, second), (q, p))
    return energy + contact_energy(medium, motion, contacts, row, 0.0)
