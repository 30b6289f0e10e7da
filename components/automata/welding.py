"""Cold welding: a contact that is pressed hard and hardly slides becomes a link again.

    N / S' >= pressure        and        |sliding speed| <= slip_speed

The switching unlinked -> linked of movable cellular automata: Psakhie et al. (2003), section 2.2. Pairs that the packing linked
once are linked again, where their line of centres lies within 45 degrees of the axis of their link. The new link carries what
the contact carried, and its strains count from there. Specimens have one material here: see `parameters`.

Kicks before and after a drift do half of their forces times its way each, which for springs is the change of their energy. Of a
link that gets other strains between the two it is not: what the forces of either would do has to be known (`_drift_work`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .contacts import (
    FIRST,
    SECOND,
    SLOT,
    START,
    approach,
    link_at,
    put,
    separation,
    sliding_speed,
    stiffnesses,
    weight_of,
)
from .energies import condensation, dilation, whole_energy
from .lattice import (
    ANGLE,
    COSINE,
    EPS,
    EX,
    EY,
    FACE,
    FIRST_SHARE,
    GAMMA,
    LAME,
    SECOND_SHARE,
    SHEAR,
    SINE,
    SPIN,
    VX,
    VY,
    X,
    Y,
    update_ghosts,
)
from .pair import half_turn, pair_strain
from .release import LINKING, scheduled_weight

# Part of the energy that is rounding.
_ROUNDING = 1e-9


class Neighbourhood(NamedTuple):
    """The automata on which the energy of a pair and of its volumes depends: both and their neighbours. Scratch.

    Attributes:
        neighbours: see `packing.Packing`, shape (n, slots).
        members: places of these automata, shape (k,).
        places: displacements of these before they are moved, shape (k, 2) [m].
        origins: of the links of both ends of a pair, shape (2,).
    """

    neighbours: npt.NDArray[np.int32]
    members: npt.NDArray[np.int64]
    places: FloatArray
    origins: FloatArray


def make_neighbourhood(neighbours: npt.NDArray[np.int32]) -> Neighbourhood:
    """Return room for the neighbourhood of a pair."""
    room = 2 * (neighbours.shape[1] + 1)
    return Neighbourhood(neighbours, np.zeros(room, dtype=np.int64), np.zeros((room, 3)), np.zeros(2))


class _Pair(NamedTuple):
    """A pair whose link is being made, and what it was before the step.

    Attributes:
        row: of its contact.
        before: weight of the link before the step.
        after: weight after it; the kick is made with the mean of both.
        near: its `Neighbourhood`.
        members: how many automata are in that.
        time: of the drift before the step [s].
        energy: `release.whole_energy` before [J].
        work: `_drift_work` before [J].
    """

    row: int
    before: float
    after: float
    near: Neighbourhood
    members: int
    time: float
    energy: float
    work: float


@jit
def linking_pressures(medium, motion, links, contacts, pressure_out):
    """Write the pressures of contacts that may be linked by them, of others -1, shape (used,) [Pa].

    Such a pair was linked once and is released, it slides slowly enough, and its line of centres lies within 45 degrees of the
    axis that its link had and has.

    Args:
        medium: a `links.Medium`.
        motion: a `lattice.Motion`.
        links: of a `lattice.Scratch`, with the strains of the present positions.
        contacts: `contacts.Contacts`.
        pressure_out: written.
    """
    body, ground, pairs, place = medium.body, medium.ground, contacts.pairs, medium.body.layout.place
    for row in range(contacts.used):
        pressure_out[row] = -1.0
        i, j = pairs[row, FIRST], pairs[row, SECOND]
        if pairs[row, SLOT] < 0 or weight_of(body.layout, medium.histories.weight, pairs, row) > 0.0:
            continue
        x, y, r = separation(ground, place, motion, i, j)
        overlap = contacts.rest[row] - r
        if not overlap > 0.0 or r == 0.0:
            continue
        q, p = link_at(body.layout, pairs, row)
        slides = abs(sliding_speed(approach(place, motion, i, j), x / r, y / r, r)) > medium.law.linking[1]
        if not slides and abs(links[GAMMA, q, p]) <= 1.0 + links[EPS, q, p]:
            # Of whole automata: the pressure does not depend on the part of their cells that there is.
            stiffness = ground.normal[i] * overlap * (2.0 * body.cells[SHEAR, p])
            pressure_out[row] = stiffness / (ground.tangential[i] * body.diameter)


@jit
def raise_weights(specimen, contacts, tick, time, near):
    """Raise the weights of links that are made again, and count the energy that this takes.

    In each step such a link gets the strains at which it carries what its contact carries, and is pressed a little more or
    less, so that this takes no energy: as links are made, the volumes of both automata become stiffer. Where no such strain is
    near, it may take energy; it never makes any, but waits for the next step.

    Args:
        specimen: a `ticks.Specimen`; its histories and losses are updated.
        contacts: `contacts.Contacts`, updated in place.
        tick: number of the step.
        time: since the forces were computed last [s].
        near: a `Neighbourhood`, overwritten.

    Returns:
        Whether any weight was raised.
    """
    medium, motion, scratch, layout = specimen.medium, specimen.motion, specimen.scratch, specimen.medium.body.layout
    raised = False
    for row in range(contacts.used):
        weight = weight_of(layout, medium.histories.weight, contacts.pairs, row)
        if contacts.pairs[row, SLOT] < 0 or contacts.pairs[row, START] >= 0 or weight == 1.0:
            continue
        raised = True
        after = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
        q, p = link_at(layout, contacts.pairs, row)
        near.origins[0], near.origins[1] = medium.histories.origin_eps[q, p], medium.histories.origin_gamma[q, p]
        count = _gather_members(medium, motion, contacts, row, near)
        energy = whole_energy(medium, motion, scratch.links, contacts, row)
        pair = _Pair(row, weight, after, near, count, time, energy, 0.0)
        work = _drift_work(medium, motion, scratch, contacts, pair)
        pair = _Pair(row, weight, after, near, count, time, energy, work)
        taken = _raise_weight(medium, motion, scratch, contacts, pair, 1.0, 0.0)
        if abs(taken) > _ROUNDING * energy:
            _put_back(medium, contacts, pair)
            taken = _raise_neutrally(medium, motion, scratch, contacts, pair, taken)
        specimen.losses[LINKING] += taken
    return raised


@internal
def _raise_weight(medium, motion, scratch, contacts, pair, part, more):
    """Raise the weight of a link, strain it as `_strain_link` does, and return the energy that this takes [J].

    The strains of the drift before are released, so that the kick does not feel them: what the forces would have done in it
    more than they do is no loss.

    Args:
        medium: a `links.Medium`; its histories are updated.
        motion: a `lattice.Motion`; its velocities are those of the drift before.
        scratch: a `lattice.Scratch`.
        contacts: `contacts.Contacts`.
        pair: a `_Pair`.
        part: see `_strain_link`.
        more: see there.
    """
    _strain_link(medium, motion, scratch, contacts, pair, part, more)
    taken = pair.energy - whole_energy(medium, motion, scratch.links, contacts, pair.row)
    taken += 0.5 * (pair.work + _drift_work(medium, motion, scratch, contacts, pair))
    put(medium.histories.weight, medium.body.layout, contacts.pairs, pair.row, 0.5 * (pair.before + pair.after))
    return taken - _drift_work(medium, motion, scratch, contacts, pair)


@internal
def _put_back(medium, contacts, pair):
    """Give the link of a pair the weight and the strains that it had before the step."""
    _put_origin(medium, contacts, pair.row, pair.near.origins[0], pair.near.origins[1])
    put(medium.histories.weight, medium.body.layout, contacts.pairs, pair.row, pair.before)


@internal
def _put_origin(medium, contacts, row, eps, gamma):
    put(medium.histories.origin_eps, medium.body.layout, contacts.pairs, row, eps)
    put(medium.histories.origin_gamma, medium.body.layout, contacts.pairs, row, gamma)


@internal
def _raise_neutrally(medium, motion, scratch, contacts, pair, taken):
    """Raise the weight of a link so that this takes no energy, or else as little as there is; return what it takes [J].

    Arguments as for `_raise_weight`; `taken` is what it would take with the strains of the contact [J].
    """
    _, _, r = separation(
        medium.ground, medium.body.layout.place, motion, contacts.pairs[pair.row, FIRST], contacts.pairs[pair.row, SECOND]
    )
    unit, more = max(contacts.rest[pair.row] - r, 0.0) / medium.body.diameter, np.nan
    if unit > 0.0:
        # Less strain and more show with how much it takes nothing.
        pressed_more = _raise_weight(medium, motion, scratch, contacts, pair, 1.0, -unit)
        _put_back(medium, contacts, pair)
        pressed_less = _raise_weight(medium, motion, scratch, contacts, pair, 1.0, unit)
        _put_back(medium, contacts, pair)
        more = _neutral_strain(pressed_more, taken, pressed_less, unit)
    if more == more:
        return _raise_weight(medium, motion, scratch, contacts, pair, 1.0, more)
    if taken < 0.0 < pair.before:
        contacts.pairs[pair.row, START] -= 1
        return 0.0
    # One that has not begun cannot wait: where it would make energy it begins without strains.
    return _raise_weight(medium, motion, scratch, contacts, pair, 0.0 if taken < 0.0 else 1.0, 0.0)


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


@internal
def _strain_link(medium, motion, scratch, contacts, pair, part, more):
    """Give a link its weight after the step, and strains at which it carries what its contact would carry alone.

    Its history goes on: what is left of its stiffness, and the strains that have flowed, which its free faces kept.

    Args:
        medium: a `links.Medium`; its histories are updated.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`.
        contacts: `contacts.Contacts`.
        pair: a `_Pair`.
        part: of these strains.
        more: strain along the link beyond that.
    """
    body, h, links, row = medium.body, medium.histories, scratch.links, pair.row
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    q, p = link_at(body.layout, contacts.pairs, row)
    # The link may begin at the second automaton: the force on that is the opposite one.
    sign = 1.0 if slot < body.layout.offset.size else -1.0
    twice = 2.0 * body.cells[SHEAR, p] * (1.0 + h.stiffness[q, p])
    x, y, r = separation(medium.ground, body.layout.place, motion, i, j)
    normal, tangential = stiffnesses(medium.ground, i, j)
    overlap = max(contacts.rest[row] - r, 0.0)
    push, drag = normal * overlap, tangential * (contacts.slid[row] if overlap > 0.0 else 0.0)
    fx, fy = sign * (-push * x - drag * y) / r, sign * (-push * y + drag * x) / r
    nx, ny = links[EX, q, p], links[EY, q, p]
    along, across = fx * nx + fy * ny, fy * nx - fx * ny
    # Without elastic strain of the link, and with its new weight: the volumetric part of its traction, and what a strain adds.
    eps, gamma = links[EPS, q, p] - h.plastic_eps[q, p], links[GAMMA, q, p] - h.plastic_gamma[q, p]
    _put_origin(medium, contacts, row, eps, gamma)
    put(medium.histories.weight, medium.body.layout, contacts.pairs, row, pair.after)
    begin, end = (i, j) if slot < body.layout.offset.size else (j, i)
    first, second = body.layout.place[begin], body.layout.place[end]
    others = 0.5 * body.cells[LAME, p] * (dilation(body, h, links, first) + dilation(body, h, links, second))
    slope = body.links[FIRST_SHARE, q, p] / condensation(body, h, first) + body.links[SECOND_SHARE, q, p] / condensation(
        body, h, second
    )
    slope *= 0.5 * body.cells[LAME, p] * pair.after
    eps -= part * (along / body.links[FACE, q, p] - others) / (twice + slope) + more
    gamma -= part * across / (body.links[FACE, q, p] * twice)
    _put_origin(medium, contacts, row, eps, gamma)


@internal
def _gather_members(medium, motion, contacts, row, near):
    """Write the neighbourhood of the pair of a contact, and return how many automata are in it."""
    count = 0
    for one in (contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]):
        for slot in range(-1, near.neighbours.shape[1]):
            member = medium.body.layout.place[one if slot < 0 else near.neighbours[one, slot]]
            known = False
            for place in range(count):
                known = known or near.members[place] == member
            if not known:
                near.members[count] = member
                near.places[count, 0], near.places[count, 1] = motion[X, member], motion[Y, member]
                near.places[count, 2] = motion[ANGLE, member]
                count += 1
    return count


@internal
def _drift(medium, motion, scratch, contacts, pair, time):
    """Move a neighbourhood for a time from where it was gathered, and write its strains."""
    near, forces, layout = pair.near, scratch.cells, medium.body.layout
    for place in range(pair.members):
        member = near.members[place]
        motion[X, member] = near.places[place, 0] + time * motion[VX, member]
        motion[Y, member] = near.places[place, 1] + time * motion[VY, member]
        motion[ANGLE, member] = near.places[place, 2] + time * motion[SPIN, member]
        forces[COSINE, member], forces[SINE, member] = half_turn(motion[ANGLE, member])
    for moved in (motion[X], motion[Y], motion[ANGLE], forces[COSINE], forces[SINE]):
        update_ghosts(layout.ghosts, moved)
    for one in (contacts.pairs[pair.row, FIRST], contacts.pairs[pair.row, SECOND]):
        for q in range(layout.offset.size):
            _strain_at(medium, motion, scratch, q, layout.place[one])
            _strain_at(medium, motion, scratch, q, layout.place[one] - layout.offset[q])


@internal
def _strain_at(medium, motion, scratch, q, p):
    """Write the strains of one link."""
    body, links, forces, j = medium.body, scratch.links, scratch.cells, p + medium.body.layout.offset[q]
    inverse = 1.0 / body.diameter
    links[EPS, q, p], links[GAMMA, q, p], links[EX, q, p], links[EY, q, p] = pair_strain(
        (inverse * motion[X, j] - inverse * motion[X, p], inverse * motion[Y, j] - inverse * motion[Y, p]),
        (forces[COSINE, p], forces[SINE, p]), (forces[COSINE, j], forces[SINE, j]), body.normal[q, 0], body.normal[q, 1],
    )  # fmt: skip


@internal
def _drift_work(medium, motion, scratch, contacts, pair):
    """Return the work of the forces of a pair and its volumes along the way of a drift, in the positions as they are [J]."""
    # Energies are of second order in the displacements: over the same way before and after, the difference is exact.
    _drift(medium, motion, scratch, contacts, pair, -0.5 * pair.time)
    work = whole_energy(medium, motion, scratch.links, contacts, pair.row)
    _drift(medium, motion, scratch, contacts, pair, 0.5 * pair.time)
    work -= whole_energy(medium, motion, scratch.links, contacts, pair.row)
    _drift(medium, motion, scratch, contacts, pair, 0.0)
    return work
