"""Pairs that are not linked: they press, rub, and do not pull; and how they are found.

    N = k_n (R - r) where r < R, 0 otherwise,        k_n = S' (2 G + c lambda) / D
    T = k_t xi, at most mu N,                        k_t = S' 2 G / D
    U = (1/2) k_n (R - r)^2 + (1/2) k_t xi^2

R is the distance at rest: the diameter D, or less where two automata were nearer than that when their contact began; it then
grows with r up to D, so that no contact begins with an energy that nothing gave. xi is what the contact has slid since it
closed, less the part that friction has released; friction dissipates the energy of that part. S' is the face of a whole cell,
less for parts of cells, c the share of one pair in the volume: a contact is as stiff as the link was. While a link is released,
its contact takes over, with 1 - w of these.

A dashpot may act in addition to the spring: N_d = -c dr/dt, c = 2 zeta sqrt(k_n m), 1/m = 1/m_i + 1/m_j, at least -N, so that
both together do not pull. Its force belongs to the velocities before a kick; what it takes is counted with the mean of those
before and after it, which is exact.

All that a contact takes is counted as the work that the kicks before and after a drift do on it, half of each, less the change
of its energy. In the drift in which a pair closes, of the way c, that is k_n o (c - o) / 2 too much, with o the overlap after
it; in the drift in which it opens as much is given back. Without a dashpot both are alike in the mean; with one the pair comes
apart more slowly than it met, and what is not given back belongs to what the dashpot takes.

Pairs that may touch are found by cells, in the order of their automata. Automata inside a whole piece are left out while its
strains are small: they touch nothing but their neighbours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .energies import link_at, medium_energy
from .links import strain_medium

# Columns of `Contacts.pairs`.
FIRST, SECOND, SLOT, START = 0, 1, 2, 3
# How much farther than contact pairs are looked for, in diameters; the list then holds until somebody has moved half of that.
SKIN = 0.3
# Cells farther out than this are not told apart any more.
_FARTHEST = 2.0**30


class Ground(NamedTuple):
    """Places of automata in whole numbers: differences of places are exact, and those of mirrored pairs mirrored.

    Attributes:
        places: whole numbers of `unit`, shape (n, 2), int32.
        unit: shape (2,) [m].
        period: after which length a specimen begins again along x and y, 0 where it does not, shape (2,) [m].
        normal: stiffness k_n between whole automata of the material of each, shape (n,) [N/m].
        tangential: stiffness k_t between these, likewise [N/m].
        part: of a whole cell, of each automaton, shape (n,).
        friction: coefficient mu.
        damping: zeta, in parts of critical damping.
    """

    places: npt.NDArray[np.int32]
    unit: FloatArray
    period: FloatArray
    normal: FloatArray
    tangential: FloatArray
    part: FloatArray
    friction: float
    damping: float


class Contacts(NamedTuple):
    """Pairs that may touch, in the order of their automata when they were found.

    Attributes:
        pairs: first automaton, second one, slot of the first where they were linked once (or -1), internal step t in which the
            link broke, or -1 - t where it was made again; shape (m, 4), int64.
        slid: xi of each, shape (m,) [m].
        rest: distance R of each, 0 for one that was just found: `add_contacts` then writes it, shape (m,) [m].
        dashpot: force of the dashpot on the first automaton, for the kick that follows, shape (m, 2) [N]; scratch.
        used: how many contacts there are; the lists may have more room.
    """

    pairs: npt.NDArray[np.int64]
    slid: FloatArray
    rest: FloatArray
    dashpot: FloatArray
    used: int


@internal_inlined
def separation(medium, motion, i, j):
    """Return the way from one automaton to another, x and y, and its length [m]."""
    ground, p, q = medium.ground, medium.body.layout.place[i], medium.body.layout.place[j]
    x = ground.unit[0] * (ground.places[j, 0] - ground.places[i, 0]) + (motion.x[q] - motion.x[p])
    y = ground.unit[1] * (ground.places[j, 1] - ground.places[i, 1]) + (motion.y[q] - motion.y[p])
    if ground.period[0] > 0.0:
        x -= ground.period[0] * np.rint(x / ground.period[0])
    if ground.period[1] > 0.0:
        y -= ground.period[1] * np.rint(y / ground.period[1])
    return x, y, np.sqrt(x * x + y * y)


@internal_inlined
def stiffnesses(ground, i, j):
    """Return the stiffness of a contact along and across its line of centres, of two halves in series [N/m]."""
    part = min(ground.part[i], ground.part[j])
    return part * _in_series(ground.normal, i, j), part * _in_series(ground.tangential, i, j)


@internal_inlined
def _in_series(stiffness, i, j):
    if stiffness[i] == stiffness[j]:
        return stiffness[i]
    return 2.0 * (stiffness[i] * stiffness[j]) / (stiffness[i] + stiffness[j])


@internal_inlined
def contact_weight(medium, pairs, row):
    """Return the part of a contact that acts: all of it but where its link is not released yet."""
    if pairs[row, SLOT] < 0:
        return 1.0
    q, p = link_at(medium.body.layout, pairs[row, FIRST], pairs[row, SECOND], pairs[row, SLOT])
    return 1.0 - medium.histories.weight[q, p]


@internal_inlined
def _earlier_weight(medium, pairs, row, weight):
    """Return `contact_weight` before the present kick, where its link may have the mean weight of this step."""
    if 0.0 < weight < 1.0:
        release = medium.law.release
        return weight - 0.5 / release if pairs[row, START] >= 0 else weight + 0.5 / release
    return weight


class Approach(NamedTuple):
    """The motion of the second automaton of a pair relative to the first, and half of the sum of both spins."""

    vx: float
    vy: float
    spin: float


@internal_inlined
def approach(medium, motion, i, j):
    """Return the `Approach` of two automata."""
    p, q = medium.body.layout.place[i], medium.body.layout.place[j]
    return Approach(motion.vx[q] - motion.vx[p], motion.vy[q] - motion.vy[p], 0.5 * (motion.spin[p] + motion.spin[q]))


@internal_inlined
def sliding_speed(relative, nx, ny, r):
    """Return how fast the second automaton slides over the first, across the line of centres [m/s]."""
    return (relative.vy * nx - relative.vx * ny) - r * relative.spin


@internal_inlined
def _way_slid(relative, x, y, r, time):
    """Return how far the second automaton has slid over the first in a straight drift of `time` [s] to where they are [m].

    With the mean of the directions before and after it: the kicks there work along both, and sums close at second order.
    """
    old_x, old_y = x - time * relative.vx, y - time * relative.vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    before = 0.0 if old_r == 0.0 else sliding_speed(relative, old_x / old_r, old_y / old_r, old_r)
    return 0.5 * time * (before + sliding_speed(relative, x / r, y / r, r))


@internal_inlined
def _kink_work(relative, x, y, r, before, after, time):
    """Return what kicks of a unit spring do beyond its change of energy, in a drift in which a pair closes or opens [m^2].

    Args:
        relative: the `Approach` in the drift.
        x: way from the first automaton to the second after the drift, x [m].
        y: the same, y [m].
        r: its length [m].
        before: distance at rest before the drift [m].
        after: overlap after it [m].
        time: of the drift [s].
    """
    old_x, old_y = x - time * relative.vx, y - time * relative.vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    overlap = before - old_r
    if after > 0.0 and not overlap > 0.0:
        return 0.5 * after * (-time * (relative.vx * x + relative.vy * y) / r - after)
    if overlap > 0.0 and not after > 0.0 and old_r > 0.0:
        return -0.5 * overlap * (time * (relative.vx * old_x + relative.vy * old_y) / old_r - overlap)
    return 0.0


@internal
def contact_energy(medium, motion, contacts, row, later):
    """Return the energy of a contact; `later` is the time for which it has slid since `slid` was noted [s]."""
    i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
    x, y, r = separation(medium, motion, i, j)
    overlap = contacts.rest[row] - r
    if not overlap > 0.0 or r == 0.0:
        return 0.0
    slid = contacts.slid[row]
    if later > 0.0:
        slid += later * sliding_speed(approach(medium, motion, i, j), x / r, y / r, r)
    normal, tangential = stiffnesses(medium.ground, i, j)
    return 0.5 * contact_weight(medium, contacts.pairs, row) * (normal * overlap * overlap + tangential * slid * slid)


@internal_inlined
def _dashpot_force(medium, closing, i, j, stiffness, push):
    """Return what the dashpot of a contact adds to its push, so that both together do not pull [N]."""
    body = medium.body
    first, second = body.mass[body.layout.place[i]], body.mass[body.layout.place[j]]
    mass = first * second / (first + second)
    return max(2.0 * medium.ground.damping * np.sqrt(stiffness * mass) * closing, -push)


@internal
def add_contacts(medium, motion, contacts, time, forces):
    """Add the forces of contacts, in their order, and let them slide; each pair pushes both automata with the same bits.

    Args:
        medium: a `links.Medium`.
        motion: a `lattice.Motion`; its velocities are those since the forces were computed last.
        contacts: `Contacts`, updated in place.
        time: since the forces were computed last [s]; 0 for readings.
        forces: `lattice.Forces`, updated in place.

    Returns:
        The energies that friction took, and dashpots beyond `dashpot_power` [J].
    """
    rubbed, damped, ground = 0.0, 0.0, medium.ground
    for row in range(contacts.used):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        x, y, r = separation(medium, motion, i, j)
        known, before = contacts.rest[row], contacts.slid[row]
        rest = min(medium.body.diameter, max(known, r))
        contacts.rest[row] = rest
        overlap = rest - r
        contacts.dashpot[row, 0] = contacts.dashpot[row, 1] = 0.0
        if r == 0.0:
            contacts.slid[row] = 0.0
            continue
        weight, relative = contact_weight(medium, contacts.pairs, row), approach(medium, motion, i, j)
        normal, tangential = stiffnesses(ground, i, j)
        if ground.damping > 0.0 and time > 0.0:
            damped += weight * normal * _kink_work(relative, x, y, r, known, overlap, time)
        if before == 0.0 and not overlap > 0.0:
            continue
        slid = before + _way_slid(relative, x, y, r, time)
        # Nothing is kept where the pair has come apart.
        most = ground.friction * normal * max(overlap, 0.0) / tangential
        kept = min(max(slid, -most), most)
        # The kicks before and after give the mean of both forces times the way: the released part costs that mean.
        earlier = _earlier_weight(medium, contacts.pairs, row, weight)
        rubbed += 0.5 * earlier * tangential * (before + kept) * (slid - kept)
        contacts.slid[row] = kept
        if not overlap > 0.0:
            continue
        nx, ny = x / r, y / r
        push, drag = weight * normal * overlap, weight * tangential * kept
        if ground.damping > 0.0:
            closing = -(relative.vx * nx + relative.vy * ny)
            more = _dashpot_force(medium, closing, i, j, weight * normal, push)
            contacts.dashpot[row, 0], contacts.dashpot[row, 1] = -more * nx, -more * ny
            push += more
        fx, fy = -push * nx - drag * ny, -push * ny + drag * nx
        p, q = medium.body.layout.place[i], medium.body.layout.place[j]
        forces.x[p] += fx
        forces.y[p] += fy
        forces.x[q] -= fx
        forces.y[q] -= fy
        forces.torque[p] += 0.5 * r * drag
        forces.torque[q] += 0.5 * r * drag
    return rubbed, damped


@jit
def add_contact_forces(medium, motion, contacts, forces):
    """Call `add_contacts` without any time in which they slide, for readings."""
    add_contacts(medium, motion, contacts, 0.0, forces)


@internal
def dashpot_power(medium, contacts, motion):
    """Return what the dashpots take at these velocities, with the forces that they have [W]."""
    power = 0.0
    for row in range(contacts.used):
        relative = approach(medium, motion, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        power += contacts.dashpot[row, 0] * relative.vx
        power += contacts.dashpot[row, 1] * relative.vy
    return power


@jit
def stored_energies(medium, motion, scratch, contacts, later):
    """Return the energy of links and volumes, and that of contacts [J]; `later` as for `contact_energy`."""
    strain_medium(medium, motion, scratch)
    total = 0.0
    for row in range(contacts.used):
        total += contact_energy(medium, motion, contacts, row, later)
    return medium_energy(medium, scratch), total


@jit
def pressing_contacts(medium, motion, contacts):
    """Return how many contacts press, and their largest overlap [m]."""
    touching, largest = 0, 0.0
    for row in range(contacts.used):
        _, _, r = separation(medium, motion, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        if contact_weight(medium, contacts.pairs, row) > 0.0:
            touching += 1 if r < contacts.rest[row] else 0
            largest = max(largest, contacts.rest[row] - r)
    return touching, largest


# -- finding them -----------------------------------------------------------------------------------------------------------


def find_pairs(
    positions: FloatArray, exposed: npt.NDArray[np.int64], reach: float, period: tuple[float, float]
) -> npt.NDArray[np.int64]:
    """Return the pairs of these automata that are closer than `reach`, first < second, in order, shape (m, 2).

    Args:
        positions: of all automata, shape (n, 2) [m]; finite, and no farther than 2^30 `reach` from the origin.
        exposed: automata to look at, in increasing order, shape (k,).
        reach: [m].
        period: after which length space begins again along x and y, 0 where it does not [m].
    """
    if not len(exposed):
        return np.zeros((0, 2), np.int64)
    counts = np.array([math.floor(length / reach) if length > 0.0 else 0 for length in period], np.int64)
    sizes = [length / max(count, 1) if length > 0.0 else reach for length, count in zip(period, counts.tolist(), strict=True)]
    cells = np.floor(positions[exposed] / sizes).astype(np.int64)
    for axis, count in enumerate(counts.tolist()):
        if period[axis] > 0.0:
            cells[:, axis] %= max(count, 1)
    keys = (cells[:, 1] << 32) + cells[:, 0]
    order = np.argsort(keys, kind="stable")
    room = 8 * len(exposed)
    while True:
        pairs = np.empty((room, 2), np.int64)
        found = _collect(positions, exposed, cells, keys[order], order, counts, np.array(period), reach, pairs)
        if found <= room:
            return pairs[:found]
        room = found


def can_be_found(positions: FloatArray, reach: float) -> bool:
    """Return whether all positions are numbers, and not absurdly far out."""
    return bool((np.abs(positions) < _FARTHEST * reach).all())


@jit
def _collect(positions, exposed, cells, sorted_keys, order, counts, period, reach, pairs_out):
    """Write pairs as far as there is room; return how many there are."""
    found = 0
    for a in range(exposed.size):
        first, begin = exposed[a], found
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                x, y = cells[a, 0] + dx, cells[a, 1] + dy
                if period[0] > 0.0:
                    x %= max(counts[0], 1)
                if period[1] > 0.0:
                    y %= max(counts[1], 1)
                key = (y << 32) + x
                for at in range(_first_place(sorted_keys, key), exposed.size):
                    if sorted_keys[at] != key:
                        break
                    second = exposed[order[at]]
                    if second <= first:
                        continue
                    gx, gy = positions[second, 0] - positions[first, 0], positions[second, 1] - positions[first, 1]
                    if period[0] > 0.0:
                        gx -= period[0] * np.rint(gx / period[0])
                    if period[1] > 0.0:
                        gy -= period[1] * np.rint(gy / period[1])
                    if gx * gx + gy * gy <= reach * reach:
                        found = _insert(pairs_out, begin, found, first, second)
    return found


@internal
def _first_place(sorted_keys, key):
    """Return what `np.searchsorted` does, which compiles for a quarter of a second."""
    low, high = 0, sorted_keys.size
    while low < high:
        middle = (low + high) >> 1
        if sorted_keys[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low


@internal
def _insert(pairs, begin, found, first, second):
    """Put a pair in its place among those of its first automaton, once; return how many pairs there are."""
    if found >= pairs.shape[0]:
        return found + 1
    at = found
    while at > begin and pairs[at - 1, 1] > second:
        at -= 1
    if at > begin and pairs[at - 1, 1] == second:
        return found
    for place in range(found, at, -1):
        pairs[place, 1] = pairs[place - 1, 1]
    pairs[found, 0], pairs[at, 1] = first, second
    return found + 1


@jit
def slots_of_links(layout, weight, neighbours, pairs, slot_out):
    """Write in which slot of the first automaton each pair is or was linked, -1 for none, -2 for one that holds.

    Args:
        layout: a `lattice.Layout`.
        weight: see `links.Histories`.
        neighbours: see `packing.Packing`, shape (n, slots).
        pairs: shape (k, 2).
        slot_out: shape (k,).
    """
    for row in range(pairs.shape[0]):
        first, second = pairs[row, 0], pairs[row, 1]
        slot_out[row] = -1
        for slot in range(neighbours.shape[1]):
            if neighbours[first, slot] == second:
                q, p = link_at(layout, first, second, slot)
                slot_out[row] = -2 if weight[q, p] == 1.0 else slot


def merge(
    old_pairs: npt.NDArray[np.int64], old_slid: FloatArray, old_rest: FloatArray, pairs: npt.NDArray[np.int64],
    slots: npt.NDArray[np.int64], releasing: npt.NDArray[np.bool_], count: int,
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:  # fmt: skip
    """Return the contacts of now: the pairs that were found, and those whose link is being released, with what they know.

    Args:
        old_pairs: see `Contacts`, shape (m, 4).
        old_slid: shape (m,) [m].
        old_rest: shape (m,) [m].
        pairs: that were found, in order, shape (k, 2).
        slots: see `slots_of_links`, shape (k,).
        releasing: which of the old ones are being released, shape (m,).
        count: number of automata.
    """
    free = slots > -2
    fresh = np.stack([pairs[free, 0], pairs[free, 1], slots[free], np.zeros(int(free.sum()), np.int64)], axis=1)
    keys = fresh[:, 0] * count + fresh[:, 1]
    old_keys = old_pairs[:, 0] * count + old_pairs[:, 1]
    kept = releasing & ~np.isin(old_keys, keys)
    rows = np.concatenate([fresh, old_pairs[kept]])
    keys = np.concatenate([keys, old_keys[kept]])
    order = np.argsort(keys, kind="stable")
    rows, keys = rows[order], keys[order]
    slid, rest = np.zeros((2, len(rows)))
    if len(old_keys):
        by_key = np.argsort(old_keys, kind="stable")
        place = np.minimum(np.searchsorted(old_keys[by_key], keys), len(old_keys) - 1)
        known = old_keys[by_key][place] == keys
        source = by_key[place[known]]
        rows[known], slid[known], rest[known] = old_pairs[source], old_slid[source], old_rest[source]
    return rows, slid, rest
