"""Pairs that are not linked: they press, rub, and do not pull.

    N = k_n (D - r) where r < D, 0 otherwise,        k_n = S' (2 G + c lambda) / D
    T = k_t xi, at most mu N,                        k_t = S' 2 G / D
    U = (1/2) k_n (D - r)^2 + (1/2) k_t xi^2

xi is what the contact has slid since it closed, less what friction has let go; what friction takes of its energy is lost. S' is
the face of a whole cell, less for parts of cells, c the share of one pair in the volume: a contact is as stiff as the link was.
While a broken link is released, its contact takes over, with 1 - w of these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.arrays import FloatArray
from ..support.jit import inlined, jit
from .bonds import opposite_slot, pair_energy, volume_energy

# Columns of `Contacts.pairs`.
FIRST, SECOND, SLOT, START = 0, 1, 2, 3


class Ground(NamedTuple):
    """Places of automata in whole numbers: differences of places are exact, and those of mirrored pairs mirrored.

    Attributes:
        places: whole numbers of `unit`, shape (n, 2), int32.
        unit: shape (2,) [m].
        period: after which length a specimen begins again along x and y, 0 where it does not, shape (2,) [m].
        normal: stiffness k_n between whole automata [N/m].
        tangential: stiffness k_t between whole automata [N/m].
        part: of a whole cell, of each automaton, shape (n,).
        friction: coefficient mu.
    """

    places: npt.NDArray[np.int32]
    unit: FloatArray
    period: FloatArray
    normal: float
    tangential: float
    part: FloatArray
    friction: float


class Contacts(NamedTuple):
    """Pairs that may touch, in the order of their automata when they were found.

    Attributes:
        pairs: first automaton, second one, slot of the first where they were linked once (or -1), tick at which the link broke;
            shape (m, 4), int64.
        slid: xi of each, shape (m,) [m].
    """

    pairs: npt.NDArray[np.int64]
    slid: FloatArray


@inlined
def separation(ground, displacement, i, j):
    """Return the way from one automaton to another, x and y, and its length [m]."""
    x = ground.unit[0] * (ground.places[j, 0] - ground.places[i, 0]) + (displacement[j, 0] - displacement[i, 0])
    y = ground.unit[1] * (ground.places[j, 1] - ground.places[i, 1]) + (displacement[j, 1] - displacement[i, 1])
    if ground.period[0] > 0.0:
        x -= ground.period[0] * np.rint(x / ground.period[0])
    if ground.period[1] > 0.0:
        y -= ground.period[1] * np.rint(y / ground.period[1])
    return x, y, np.sqrt(x * x + y * y)


@inlined
def contact_weight(bonds, pairs, row):
    """Return the part of a contact that acts: all of it but where its link is not released yet."""
    slot = pairs[row, SLOT]
    return 1.0 if slot < 0 else 1.0 - bonds.weight[pairs[row, FIRST], slot]


@jit
def contact_energy(body, ground, bonds, motion, contacts, row, later):
    """Return the energy of a contact; `later` is the time for which it has slid since `slid` was noted [s]."""
    i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
    x, y, r = separation(ground, motion.displacement, i, j)
    overlap = body.diameter - r
    if not overlap > 0.0 or r == 0.0:
        return 0.0
    slid = contacts.slid[row]
    if later > 0.0:
        slid += later * _sliding_speed(motion, i, j, x / r, y / r, r)
    stiffness = ground.normal * overlap * overlap + ground.tangential * slid * slid
    return 0.5 * contact_weight(bonds, contacts.pairs, row) * min(ground.part[i], ground.part[j]) * stiffness


@inlined
def _sliding_speed(motion, i, j, nx, ny, r):
    """Return how fast the second automaton slides over the first, across the line of centres [m/s]."""
    vx, vy = motion.velocity[j, 0] - motion.velocity[i, 0], motion.velocity[j, 1] - motion.velocity[i, 1]
    return (vy * nx - vx * ny) - 0.5 * r * (motion.spin[i] + motion.spin[j])


@jit
def add_contacts(body, ground, bonds, motion, contacts, count, time, force, torque):
    """Add the forces of contacts, in their order, and let them slide; each pair pushes both automata with the same bits.

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        contacts: `Contacts`, `slid` updated in place.
        count: how many contacts there are.
        time: since the forces were computed last [s].
        force: shape (n, 2), updated in place [N].
        torque: shape (n,), updated in place [N m].

    Returns:
        The energy that friction took [J].
    """
    lost = 0.0
    for row in range(count):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        x, y, r = separation(ground, motion.displacement, i, j)
        overlap, slid = body.diameter - r, contacts.slid[row]
        part = contact_weight(bonds, contacts.pairs, row) * min(ground.part[i], ground.part[j])
        if not overlap > 0.0 or r == 0.0:
            lost += 0.5 * part * ground.tangential * slid * slid
            contacts.slid[row] = 0.0
            continue
        nx, ny = x / r, y / r
        before, slid = slid, slid + time * _sliding_speed(motion, i, j, nx, ny, r)
        most = ground.friction * ground.normal * overlap / ground.tangential
        kept = min(max(slid, -most), most)
        # The kicks before and after give the mean of both forces times the way: what is let go costs that mean.
        lost += 0.5 * part * ground.tangential * (before + kept) * (slid - kept)
        contacts.slid[row] = kept
        push, drag = part * ground.normal * overlap, part * ground.tangential * kept
        fx, fy = -push * nx - drag * ny, -push * ny + drag * nx
        force[i, 0] += fx
        force[i, 1] += fy
        force[j, 0] -= fx
        force[j, 1] -= fy
        torque[i] += 0.5 * r * drag
        torque[j] += 0.5 * r * drag
    return lost


@inlined
def _put_weight(body, bonds, pairs, row, weight):
    """Write the weight of a link at both of its ends."""
    i, j, slot = pairs[row, FIRST], pairs[row, SECOND], pairs[row, SLOT]
    bonds.weight[i, slot] = weight
    bonds.weight[j, opposite_slot(body.directions.shape[0], slot)] = weight


@inlined
def _scheduled_weight(pairs, row, tick, release):
    """Return the weight of a broken link after an internal step."""
    return max(0.0, 1.0 - (tick - pairs[row, START] + 1) / release)


@jit
def release_bond(body, ground, bonds, law, motion, half, contacts, row, tick):
    """Lower the weight of the broken link of a contact; return the energy that this takes [J].

    The forces of this step get the mean of the weights before and after it, as the kick belongs to both halves of the step;
    `settle_weights` then writes the weight after it.
    """
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    before, after = bonds.weight[i, slot], _scheduled_weight(contacts.pairs, row, tick, law.release)
    energy = 0.0
    for sign in (1.0, -1.0):
        energy += sign * (volume_energy(body, bonds, motion.displacement, half, i))
        energy += sign * (volume_energy(body, bonds, motion.displacement, half, j))
        energy += sign * bonds.weight[i, slot] * pair_energy(body, bonds, motion.displacement, half, i, slot)
        energy += sign * contact_energy(body, ground, bonds, motion, contacts, row, 0.0)
        _put_weight(body, bonds, contacts.pairs, row, after)
    _put_weight(body, bonds, contacts.pairs, row, 0.5 * (before + after))
    return energy


@jit
def release_bonds(body, ground, bonds, law, motion, half, contacts, count, tick):
    """Lower the weights of broken links; return the energy that this takes [J].

    Args:
        body: a `Body`.
        ground: a `Ground`.
        bonds: `Bonds`, updated in place.
        law: a `Law`.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        count: how many contacts there are.
        tick: number of the internal step.
    """
    lost = 0.0
    for row in range(count):
        slot = contacts.pairs[row, SLOT]
        if slot >= 0 and 0.0 < bonds.weight[contacts.pairs[row, FIRST], slot] < 1.0:
            lost += release_bond(body, ground, bonds, law, motion, half, contacts, row, tick)
    return lost


@jit
def settle_weights(body, bonds, law, contacts, count, tick):
    """Give links that are being released their weights after an internal step; arguments as for `release_bonds`."""
    for row in range(count):
        slot = contacts.pairs[row, SLOT]
        if slot >= 0 and 0.0 < bonds.weight[contacts.pairs[row, FIRST], slot] < 1.0:
            _put_weight(body, bonds, contacts.pairs, row, _scheduled_weight(contacts.pairs, row, tick, law.release))


@jit
def all_contact_energy(body, ground, bonds, motion, contacts, count, later):
    """Return the energy of all contacts [J]; `later` as for `contact_energy`."""
    total = 0.0
    for row in range(count):
        total += contact_energy(body, ground, bonds, motion, contacts, row, later)
    return total


@jit
def count_touching(body, ground, bonds, motion, contacts, count):
    """Return how many contacts press."""
    touching = 0
    for row in range(count):
        _, _, r = separation(ground, motion.displacement, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        if r < body.diameter and contact_weight(bonds, contacts.pairs, row) > 0.0:
            touching += 1
    return touching
