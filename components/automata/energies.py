"""The energies of links and volumes with histories, one by one, in the strains that the scratch has; see `links`."""

from __future__ import annotations

from ..support.dispatch import dispatched
from ..support.jit import internal, internal_inlined, jit
from .links import Mixture, Uniform


@internal_inlined
def link_at(layout, i, j, slot):
    """Return the direction of a link and the place where it begins, from its two automata and its slot at the first.

    In a closed specimen a link may begin at a ghost too; this is the place where it begins at an automaton.
    """
    directions = layout.offset.size
    if slot < directions:
        return slot, layout.place[i]
    return slot - directions, layout.place[j]


@internal
def put(field, layout, i, j, slot, value):
    """Write a value of a link, of a closed specimen also where its ghost begins."""
    q, p = link_at(layout, i, j, slot)
    field[q, p] = value
    end = layout.place[j] if slot < layout.offset.size else layout.place[i]
    field[q, end - layout.offset[q]] = value


@internal_inlined
def _counted_strain(medium, scratch, q, p):
    h = medium.histories
    return h.weight[q, p] * (scratch.links.eps[q, p] - h.origin_eps[q, p]) + (1.0 - h.weight[q, p]) * h.plastic_eps[q, p]


@internal_inlined
def _free_share(medium, share, q, p):
    """Return what a released face adds to the shares of free faces; its stiffness is what is left of that of the link."""
    return (1.0 - medium.histories.weight[q, p]) * share[q, p] / (1.0 + medium.histories.stiffness[q, p])


@internal
def condensation(medium, p):
    """Return 1 + a of an automaton: what its free and released faces make of the volumetric strain."""
    body, free = medium.body, medium.body.missing[p]
    for q in range(body.layout.offset.size):
        free += _free_share(medium, body.first_share, q, p)
        free += _free_share(medium, body.second_share, q, p - body.layout.offset[q])
    return 1.0 + free * body.lame[p] / (2.0 * body.shear[p])


@internal
def dilation(medium, scratch, p):
    """Return the volumetric strain of an automaton, both halves of its links being strained alike."""
    body, total = medium.body, 0.0
    for q in range(body.layout.offset.size - 1, -1, -1):
        o = body.layout.offset[q]
        total += body.first_share[q, p] * _counted_strain(medium, scratch, q, p)
        total += body.second_share[q, p - o] * _counted_strain(medium, scratch, q, p - o)
    return total / condensation(medium, p)


@internal
def link_energy(medium, scratch, q, p):
    """Return the energy of a link itself, for a weight of 1 [J]."""
    h, mixture, links = medium.histories, medium.mixture, scratch.links
    eps = (links.eps[q, p] - h.origin_eps[q, p]) - h.plastic_eps[q, p]
    gamma = (links.gamma[q, p] - h.origin_gamma[q, p]) - h.plastic_gamma[q, p]
    stiffness = mixture.along[q, p] * (eps * eps) + mixture.across[q, p] * (gamma * gamma)
    return 0.5 * medium.body.face[q, p] * medium.body.diameter * (1.0 + h.stiffness[q, p]) * stiffness


@internal
def volume_energy(medium, scratch, p):
    """Return the energy of the volumetric strain of an automaton [J]."""
    theta = dilation(medium, scratch, p)
    return 0.5 * medium.body.volume[p] * medium.body.lame[p] * condensation(medium, p) * theta * theta


@dispatched
def division_energy(mixture, medium, scratch, q, p):
    """Return by how much the division of its strain lowers the energy of a link, for a weight of 1 [J]."""


@division_energy.register(Uniform)
def _no_energy(mixture, medium, scratch, q, p):
    return 0.0


@division_energy.register(Mixture)
def _division_energy(mixture, medium, scratch, q, p):
    body, compliance = medium.body, mixture.compliance[q, p]
    if compliance == 0.0:
        return 0.0
    j = p + body.layout.offset[q]
    theta, other = dilation(medium, scratch, p), dilation(medium, scratch, _source(body.layout, j))
    eps = scratch.links.eps[q, p] - medium.histories.origin_eps[q, p]
    stress = (body.shear[p] - body.shear[j]) * eps + 0.5 * (body.lame[p] * theta - body.lame[j] * other)
    return 0.5 * body.face[q, p] * body.diameter * compliance * stress * stress


@dispatched
def divisions_around(mixture, medium, scratch, first, second, link):
    """Return by how much the divisions of strains lower the energies of all links of two neighbours [J].

    Args:
        mixture: of the medium.
        medium: a `links.Medium`.
        scratch: a `lattice.Scratch`.
        first: place of an automaton.
        second: place of its neighbour.
        link: direction of their link, and where it begins.
    """


@divisions_around.register(Uniform)
def _no_divisions(mixture, medium, scratch, first, second, link):
    return 0.0


@divisions_around.register(Mixture)
def _divisions_around(mixture, medium, scratch, first, second, link):
    # The link itself is there at both of its ends.
    total, layout = -_weighted_division(medium, scratch, link[0], link[1]), medium.body.layout
    for end in (first, second):
        for q in range(layout.offset.size):
            total += _weighted_division(medium, scratch, q, end)
            total += _weighted_division(medium, scratch, q, end - layout.offset[q])
    return total


@internal
def _weighted_division(medium, scratch, q, p):
    place = _source(medium.body.layout, p)
    return medium.histories.weight[q, p] * division_energy(medium.mixture, medium, scratch, q, place)


@internal
def _source(layout, p):
    """Return the place of the automaton that a ghost copies; of another place itself."""
    for row in range(layout.ghosts.shape[0]):
        if layout.ghosts[row, 0] == p:
            return layout.ghosts[row, 1]
    return p


@internal
def pair_and_volumes(medium, scratch, i, j, slot):
    """Return the energy of the link of two automata and of both volumes, less that of divisions of their links [J]."""
    body = medium.body
    first, second = body.layout.place[i], body.layout.place[j]
    q, p = link_at(body.layout, i, j, slot)
    energy = volume_energy(medium, scratch, first) + volume_energy(medium, scratch, second)
    energy += medium.histories.weight[q, p] * link_energy(medium, scratch, q, p)
    return energy - divisions_around(medium.mixture, medium, scratch, first, second, (q, p))


@internal
def medium_energy(medium, scratch):
    """Return the energy that is stored in all links and volumes [J]."""
    total, body = 0.0, medium.body
    for i in range(body.layout.place.size):
        p = body.layout.place[i]
        total += volume_energy(medium, scratch, p)
        for q in range(body.layout.offset.size):
            weight = medium.histories.weight[q, p]
            if weight > 0.0:
                energy = link_energy(medium, scratch, q, p) - division_energy(medium.mixture, medium, scratch, q, p)
                total += weight * energy
    return total


@jit
def largest_link_strain(medium, scratch):
    """Return the largest strain along or across a link that holds."""
    largest, h = 0.0, medium.histories
    for q in range(medium.body.layout.offset.size):
        for p in range(medium.body.mass.size):
            if h.weight[q, p] == 1.0:
                eps, gamma = scratch.links.eps[q, p] - h.origin_eps[q, p], scratch.links.gamma[q, p] - h.origin_gamma[q, p]
                largest = max(largest, abs(eps), abs(gamma))
    return largest
