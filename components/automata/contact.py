"""Pairs that are not linked: they press, rub, and do not pull.

    N = k_n (R - r) where r < R, 0 otherwise,        k_n = S' (2 G + c lambda) / D
    T = k_t xi, at most mu N,                        k_t = S' 2 G / D
    U = (1/2) k_n (R - r)^2 + (1/2) k_t xi^2

R is the distance at rest: the diameter D, or less where two automata were nearer than that when their contact began; it then
grows with r up to D, so that no contact begins with an energy that nothing gave. xi is what the contact has slid since it
closed, less what friction has let go; what friction takes of its energy is lost. S' is the face of a whole cell, less for parts
of cells, c the share of one pair in the volume: a contact is as stiff as the link was. While a link is released, its contact
takes over, with 1 - w of these.

A dashpot may press beside the spring: N_d = -c dr/dt, c = 2 zeta sqrt(k_n m), 1/m = 1/m_i + 1/m_j, at least -N, so that both
together do not pull. Its force belongs to the velocities before a kick; what it takes is counted with the mean of those before
and after it, which is exact.

All that a contact takes is counted as the work that the kicks before and after a drift do on it, half of each, less the change
of its energy. In the drift in which a pair closes, of the way c, that is k_n o (c - o) / 2 too much, with o the overlap after
it; in the drift in which it opens as much is given back. Without a dashpot both are alike in the mean; with one the pair comes
apart more slowly than it met, and what is not given back belongs to what the dashpot takes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit

# Columns of `Contacts.pairs`.
FIRST, SECOND, SLOT, START = 0, 1, 2, 3


class Ground(NamedTuple):
    """Places of automata in whole numbers: differences of places are exact, and those of mirrored pairs mirrored.

    Attributes:
        places: whole numbers of `unit`, shape (n, 2), int32.
        unit: shape (2,) [m].
        period: after which length a specimen begins again along x and y, 0 where it does not, shape (2,) [m].
        normal: stiffness k_n between whole automata, shape () or, of each where there are several materials, (n,) [N/m].
        tangential: stiffness k_t between whole automata, likewise [N/m].
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
            link broke, or -1 - t where it was made anew; shape (m, 4), int64.
        slid: xi of each, shape (m,) [m].
        rest: distance R of each, 0 for one that was just found: `add_contacts` then writes it, shape (m,) [m].
        dashpot: force of the dashpot on the first automaton, for the kick that follows, shape (m, 2) [N]; scratch.
    """

    pairs: npt.NDArray[np.int64]
    slid: FloatArray
    rest: FloatArray
    dashpot: FloatArray


@internal_inlined
def separation(ground, displacement, i, j):
    """Return the way from one automaton to another, x and y, and its length [m]."""
    x = ground.unit[0] * (ground.places[j, 0] - ground.places[i, 0]) + (displacement[j, 0] - displacement[i, 0])
    y = ground.unit[1] * (ground.places[j, 1] - ground.places[i, 1]) + (displacement[j, 1] - displacement[i, 1])
    if ground.period[0] > 0.0:
        x -= ground.period[0] * np.rint(x / ground.period[0])
    if ground.period[1] > 0.0:
        y -= ground.period[1] * np.rint(y / ground.period[1])
    return x, y, np.sqrt(x * x + y * y)


@internal_inlined
def contact_part(ground, i, j):
    """Return the part of the stiffnesses between whole automata that two have."""
    return min(ground.part[i], ground.part[j])


@internal_inlined
def contact_stiffness(stiffness, i, j):
    """Return the stiffness of a contact of two automata, from that of all or of each: two halves in series [N/m]."""
    if stiffness.ndim == 1:
        return 2.0 * (stiffness[i] * stiffness[j]) / (stiffness[i] + stiffness[j])
    return stiffness[()]


@internal_inlined
def contact_weight(bonds, pairs, row):
    """Return the part of a contact that acts: all of it but where its link is not released yet."""
    slot = pairs[row, SLOT]
    return 1.0 if slot < 0 else 1.0 - bonds.weight[pairs[row, FIRST], slot]


@internal_inlined
def _earlier_weight(bonds, pairs, row, release):
    """Return `contact_weight` before the present kick, where its link may have the mean weight of this step."""
    weight = contact_weight(bonds, pairs, row)
    if 0.0 < weight < 1.0:
        return weight - 0.5 / release if pairs[row, START] >= 0 else weight + 0.5 / release
    return weight


@internal_inlined
def sliding_speed(motion, i, j, nx, ny, r):
    """Return how fast the second automaton slides over the first, across the line of centres [m/s]."""
    vx, vy = motion.velocity[j, 0] - motion.velocity[i, 0], motion.velocity[j, 1] - motion.velocity[i, 1]
    return (vy * nx - vx * ny) - 0.5 * r * (motion.spin[i] + motion.spin[j])


@internal_inlined
def _way_slid(motion, i, j, x, y, r, time):
    """Return how far the second automaton has slid over the first in a straight drift of `time` [s] to where they are [m].

    With the mean of the directions before and after it: the kicks there work along both, and sums close at second order.
    """
    vx, vy = motion.velocity[j, 0] - motion.velocity[i, 0], motion.velocity[j, 1] - motion.velocity[i, 1]
    old_x, old_y = x - time * vx, y - time * vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    before = 0.0 if old_r == 0.0 else sliding_speed(motion, i, j, old_x / old_r, old_y / old_r, old_r)
    return 0.5 * time * (before + sliding_speed(motion, i, j, x / r, y / r, r))


@internal_inlined
def _kink_work(motion, i, j, x, y, r, before, after, time):
    """Return what kicks of a unit spring do beyond its change of energy, in a drift in which a pair closes or opens [m^2].

    Args:
        motion: a `Motion`; its velocities are those of the drift.
        i: first automaton.
        j: second one.
        x: way from the first to the second after the drift, x [m].
        y: the same, y [m].
        r: its length [m].
        before: distance at rest before the drift [m].
        after: overlap after it [m].
        time: of the drift [s].
    """
    vx, vy = motion.velocity[j, 0] - motion.velocity[i, 0], motion.velocity[j, 1] - motion.velocity[i, 1]
    old_x, old_y = x - time * vx, y - time * vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    overlap = before - old_r
    if after > 0.0 and not overlap > 0.0:
        return 0.5 * after * (-time * (vx * x + vy * y) / r - after)
    if overlap > 0.0 and not after > 0.0 and old_r > 0.0:
        return -0.5 * overlap * (time * (vx * old_x + vy * old_y) / old_r - overlap)
    return 0.0


@internal
def contact_energy(ground, bonds, motion, contacts, row, later):
    """Return the energy of a contact; `later` is the time for which it has slid since `slid` was noted [s]."""
    i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
    x, y, r = separation(ground, motion.displacement, i, j)
    overlap = contacts.rest[row] - r
    if not overlap > 0.0 or r == 0.0:
        return 0.0
    slid = contacts.slid[row]
    if later > 0.0:
        slid += later * sliding_speed(motion, i, j, x / r, y / r, r)
    energy = (
        contact_stiffness(ground.normal, i, j) * overlap * overlap + contact_stiffness(ground.tangential, i, j) * slid * slid
    )
    return 0.5 * contact_weight(bonds, contacts.pairs, row) * contact_part(ground, i, j) * energy


@internal_inlined
def _dashpot_force(body, ground, motion, part, i, j, nx, ny, push):
    """Return what the dashpot of a contact adds to its push, so that both together do not pull [N]."""
    closing = (motion.velocity[i, 0] - motion.velocity[j, 0]) * nx + (motion.velocity[i, 1] - motion.velocity[j, 1]) * ny
    first, second = body.mass[body.kind[i]], body.mass[body.kind[j]]
    mass = first * second / (first + second)
    return max(2.0 * ground.damping * np.sqrt(part * contact_stiffness(ground.normal, i, j) * mass) * closing, -push)


@internal
def add_contacts(body, ground, bonds, motion, contacts, count, release, time, force, torque):
    """Add the forces of contacts, in their order, and let them slide; each pair pushes both automata with the same bits.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        contacts: `Contacts`, updated in place.
        count: how many contacts there are.
        release: over how many internal steps a link is released.
        time: since the forces were computed last [s].
        force: shape (n, 2), updated in place [N].
        torque: shape (n,), updated in place [N m].

    Returns:
        The energies that friction took, and dashpots beyond `dashpot_power` [J].
    """
    rubbed, damped = 0.0, 0.0
    for row in range(count):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        x, y, r = separation(ground, motion.displacement, i, j)
        known, before = contacts.rest[row], contacts.slid[row]
        rest = min(body.diameter, max(known, r))
        contacts.rest[row] = rest
        overlap = rest - r
        part = contact_weight(bonds, contacts.pairs, row) * contact_part(ground, i, j)
        contacts.dashpot[row, 0] = contacts.dashpot[row, 1] = 0.0
        normal, tangential = contact_stiffness(ground.normal, i, j), contact_stiffness(ground.tangential, i, j)
        if r == 0.0:
            contacts.slid[row] = 0.0
            continue
        if ground.damping > 0.0 and time > 0.0:
            damped += part * normal * _kink_work(motion, i, j, x, y, r, known, overlap, time)
        if before == 0.0 and not overlap > 0.0:
            continue
        slid = before + _way_slid(motion, i, j, x, y, r, time)
        # Nothing is kept where the pair has come apart.
        most = ground.friction * normal * max(overlap, 0.0) / tangential
        kept = min(max(slid, -most), most)
        # The kicks before and after give the mean of both forces times the way: what is let go costs that mean.
        earlier = _earlier_weight(bonds, contacts.pairs, row, release) * contact_part(ground, i, j)
        rubbed += 0.5 * earlier * tangential * (before + kept) * (slid - kept)
        contacts.slid[row] = kept
        if not overlap > 0.0:
            continue
        nx, ny = x / r, y / r
        push, drag = part * normal * overlap, part * tangential * kept
        if ground.damping > 0.0:
            more = _dashpot_force(body, ground, motion, part, i, j, nx, ny, push)
            contacts.dashpot[row, 0], contacts.dashpot[row, 1] = -more * nx, -more * ny
            push += more
        fx, fy = -push * nx - drag * ny, -push * ny + drag * nx
        force[i, 0] += fx
        force[i, 1] += fy
        force[j, 0] -= fx
        force[j, 1] -= fy
        torque[i] += 0.5 * r * drag
        torque[j] += 0.5 * r * drag
    return rubbed, damped


@jit
def add_contact_forces(medium, motion, contacts, count, force, torque):
    """Call `add_contacts` without any time in which they slide, for readings; arguments as for `cracking_steps.add_forces`."""
    add_contacts(medium.body, medium.ground, medium.bonds, motion, contacts, count, medium.law.release, 0.0, force, torque)


@internal
def dashpot_power(contacts, count, velocity):
    """Return what the dashpots take at these velocities, shape (n, 2) [m/s], with the forces that they have [W]."""
    power = 0.0
    for row in range(count):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        power += contacts.dashpot[row, 0] * (velocity[j, 0] - velocity[i, 0])
        power += contacts.dashpot[row, 1] * (velocity[j, 1] - velocity[i, 1])
    return power


@jit
def all_contact_energy(ground, bonds, motion, contacts, count, later):
    """Return the energy of all contacts [J]; `later` as for `contact_energy`."""
    total = 0.0
    for row in range(count):
        total += contact_energy(ground, bonds, motion, contacts, row, later)
    return total


@jit
def count_touching(ground, bonds, motion, contacts, count):
    """Return how many contacts press."""
    touching = 0
    for row in range(count):
        _, _, r = separation(ground, motion.displacement, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        if r < contacts.rest[row] and contact_weight(bonds, contacts.pairs, row) > 0.0:
            touching += 1
    return touching


@jit
def largest_overlap(ground, bonds, motion, contacts, count):
    """Return the largest overlap of a contact that presses, 0 where none does [m]."""
    largest = 0.0
    for row in range(count):
        _, _, r = separation(ground, motion.displacement, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        if contact_weight(bonds, contacts.pairs, row) > 0.0:
            largest = max(largest, contacts.rest[row] - r)
    return largest
