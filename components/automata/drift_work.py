"""The work of the forces of a pair and its volumes in a drift, where what these forces hang on changes from kick to kick.

Kicks before and after a drift do half of their forces times its way each, which for springs is the change of their energy. Of a
link that gets other strains between the two it is not: what the forces of either would do has to be known.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal
from .contact import FIRST, SECOND
from .link_release import pair_and_volumes
from .pair import half_turn


class Neighbourhood(NamedTuple):
    """The automata on which the energy of a pair and of its volumes hangs: both and their neighbours. Scratch.

    Attributes:
        members: their numbers, shape (m,).
        places: of each the displacement along x and y [m], and what `pair.orient` gives, shape (m, 4).
        origins: of the links of both, see `link_histories.Bonds`, shape (2, slots, 2).
    """

    members: npt.NDArray[np.int64]
    places: FloatArray
    origins: FloatArray


def make_neighbourhood(slots: int) -> Neighbourhood:
    """Return room for the neighbourhood of a pair whose automata have so many neighbours each."""
    room = 2 * (slots + 1)
    return Neighbourhood(np.zeros(room, dtype=np.int64), np.zeros((room, 4)), np.zeros((2, slots, 2)))


@internal
def gather_members(body, motion, half, contacts, row, near):
    """Write the neighbourhood of the pair of a contact, and return how many automata are in it.

    Args:
        body: a `Body`.
        motion: a `Motion`.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        row: of the contact.
        near: a `Neighbourhood`, overwritten.
    """
    count, slots = 0, body.directions.shape[0]
    for one in (contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]):
        for slot in range(-1, slots):
            member = one if slot < 0 else body.neighbours[one, slot]
            known = False
            for place in range(count):
                known = known or near.members[place] == member
            if not known:
                near.members[count] = member
                near.places[count, 0], near.places[count, 1] = motion.displacement[member, 0], motion.displacement[member, 1]
                near.places[count, 2], near.places[count, 3] = half[member, 0], half[member, 1]
                count += 1
    return count


@internal
def _drift(motion, half, near, count, time):
    """Move a neighbourhood for a time from where it was gathered; for 0 it is as it was, to the bit."""
    for place in range(count):
        member = near.members[place]
        x, y, less, sine = near.places[place, 0], near.places[place, 1], near.places[place, 2], near.places[place, 3]
        if time != 0.0:
            x, y = x + time * motion.velocity[member, 0], y + time * motion.velocity[member, 1]
            less, sine = half_turn(motion.rotation[member] + time * motion.spin[member])
        motion.displacement[member, 0], motion.displacement[member, 1] = x, y
        half[member, 0], half[member, 1] = less, sine


@internal
def drift_work(medium, motion, half, contacts, row, near, count, time):
    """Return the work of the forces of a pair and its volumes along the way of a drift, in the positions as they are [J].

    Args:
        medium: a `Medium`.
        motion: a `Motion`; its velocities are those of the drift.
        half: see `pair.orient`, shape (n, 2).
        contacts: `Contacts`.
        row: of the pair.
        near: the `Neighbourhood` of the pair.
        count: how many automata are in it.
        time: of the drift [s].
    """
    # Energies are of second order in the displacements: over the same way before and after, the difference is exact.
    _drift(motion, half, near, count, -0.5 * time)
    work = pair_and_volumes(medium.body, medium.ground, medium.bonds, motion, half, contacts, row)
    _drift(motion, half, near, count, 0.5 * time)
    work -= pair_and_volumes(medium.body, medium.ground, medium.bonds, motion, half, contacts, row)
    _drift(motion, half, near, count, 0.0)
    return work
