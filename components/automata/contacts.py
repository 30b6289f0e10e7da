"""Contacts: repulsion and friction of unlinked pairs, without attraction, and the search for contacts.

    N = k_n (R - r) if r < R, 0 otherwise,           k_n = S' (2 G + c lambda) / D
    T = k_t xi, at most mu N,                        k_t = S' 2 G / D
    U = (1/2) k_n (R - r)^2 + (1/2) k_t xi^2

R is the rest distance: the diameter D, or less if the automata were closer when their contact began. It grows with r up to D,
so that no contact begins with spurious energy. xi is the slip since the contact closed, minus the part that friction has
released; friction dissipates the energy of that part. S' is the face of a whole cell (less for parts of cells), c the share of
one link's strain in the volume strain: a contact is as stiff as the link was. A link of weight w has a contact of weight 1 - w.

A dashpot may act in addition to the spring: N_d = -c dr/dt, c = 2 zeta sqrt(k_n m), 1/m = 1/m_i + 1/m_j. It is at least -N,
so that the sum is never attractive. Its force follows from the velocities before a kick; its dissipation is computed from the
mean of the velocities before and after the kick, which is exact.

The dissipation of a contact is the work of the adjacent half kicks over a drift minus the change of its energy. In a drift of
length c in which a pair closes, this is too large by k_n o (c - o) / 2, with o the overlap afterwards; in a drift in which it
opens, it is too small by as much. Without a dashpot both errors cancel on average. With a dashpot the pair separates more
slowly than it met, and the remainder counts as dissipation of the dashpot.

The search visits pairs in the order of their automata. It omits automata inside an intact piece while its strains are small,
because they touch only their neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined
from .lattice import FORCE_X, FORCE_Y, MASS, SPIN, TORQUE, VX, VY, X, Y

# Columns of `Contacts.pairs`.
FIRST, SECOND, SLOT, START = 0, 1, 2, 3
# The search finds pairs up to this distance beyond contact [diameters]; the list is valid until an automaton moves half of it.
SKIN = 0.3
# The search refuses positions whose coordinates exceed this multiple of the search distance.
_FARTHEST = 2.0**30


class ContactConstants(NamedTuple):
    """Constants of contacts. Initial positions are integers: differences are exact, and mirror images for mirrored pairs.

    Attributes:
        places: initial positions of the automata in multiples of `unit`, shape (n, 2), int32.
        unit: length of one step of `places` along x and y [m].
        period: length of a periodic specimen along x and y, 0 if not periodic [m].
        normal: stiffness k_n between whole automata of the material of each automaton, shape (n,) [N/m].
        tangential: stiffness k_t, likewise, shape (n,) [N/m].
        part: fraction of a whole cell that each automaton has, shape (n,).
        friction: coefficient mu.
        damping: damping ratio zeta of the dashpots.
    """

    places: npt.NDArray[np.int32]
    unit: tuple[float, float]
    period: tuple[float, float]
    normal: FloatArray
    tangential: FloatArray
    part: FloatArray
    friction: float
    damping: float


class Contacts(NamedTuple):
    """Pairs of automata that may touch, in the order of their numbers at the time of the search.

    Attributes:
        pairs: columns: first automaton; second one; slot (direction) of their link at the first one, -1 if never linked; tick
            t in which the link broke, or -1 - t if it was formed again in tick t; shape (m, 4), int64.
        slid: slip xi of each pair, shape (m,) [m].
        rest: rest distance R of each pair, 0 for a new pair until `add_contact_forces` writes it, shape (m,) [m].
        dashpot: scratch: force of the dashpot on the first automaton in the next kick, shape (m, 2) [N].
        push: scratch: force of spring and dashpot along the line of centres, shape (m,) [N].
        used: number of pairs in use; the arrays can be longer.
    """

    pairs: npt.NDArray[np.int64]
    slid: FloatArray
    rest: FloatArray
    dashpot: FloatArray
    push: FloatArray
    used: int


def empty_contacts() -> Contacts:
    """Return empty lists of contacts."""
    return Contacts(np.zeros((0, 4), np.int64), np.zeros(0), np.zeros(0), np.zeros((0, 2)), np.zeros(0), 0)


@internal_inlined
def contact_link(layout, pairs, row):
    """Return the direction of the link that a contact once was, and the index in the fields where this link begins.

    In a periodic specimen a link can be stored at an automaton and at its ghost; the index is that of the automaton.
    """
    directions, slot = layout.offset.size, pairs[row, SLOT]
    if slot < directions:
        return slot, layout.place[pairs[row, FIRST]]
    return slot - directions, layout.place[pairs[row, SECOND]]


@internal
def write_link_value(field, layout, pairs, row, value):
    """Write `value` at the link that a contact once was; in a periodic specimen also at the ghost where the link begins."""
    q, p = contact_link(layout, pairs, row)
    field[q, p] = value
    end = layout.place[pairs[row, SECOND if pairs[row, SLOT] < layout.offset.size else FIRST]]
    field[q, end - layout.offset[q]] = value


@internal_inlined
def link_weight(layout, weight, pairs, row):
    """Return the weight of the link between the pair of a contact, 0 if never linked; `weight` is that of `links.Histories`."""
    if pairs[row, SLOT] < 0:
        return 0.0
    q, p = contact_link(layout, pairs, row)
    return weight[q, p]


@internal_inlined
def separation(constants, place, motion, i, j):
    """Return the vector from automaton i to automaton j: x, y, and its length [m]."""
    p, q = place[i], place[j]
    x = constants.unit[0] * (constants.places[j, 0] - constants.places[i, 0]) + (motion[X, q] - motion[X, p])
    y = constants.unit[1] * (constants.places[j, 1] - constants.places[i, 1]) + (motion[Y, q] - motion[Y, p])
    if constants.period[0] > 0.0:
        x -= constants.period[0] * np.rint(x / constants.period[0])
    if constants.period[1] > 0.0:
        y -= constants.period[1] * np.rint(y / constants.period[1])
    return x, y, np.sqrt(x * x + y * y)


@internal_inlined
def contact_stiffnesses(constants, i, j):
    """Return the normal and the tangential stiffness of a contact [N/m], from its two automata as springs in series."""
    part = min(constants.part[i], constants.part[j])
    return part * _series_stiffness(constants.normal, i, j), part * _series_stiffness(constants.tangential, i, j)


@internal_inlined
def _series_stiffness(stiffness, i, j):
    if stiffness[i] == stiffness[j]:
        return stiffness[i]
    return 2.0 * (stiffness[i] * stiffness[j]) / (stiffness[i] + stiffness[j])


@internal_inlined
def _weight_before_kick(release_ticks, start, weight):
    """Return the weight of a contact before the present kick; its link may already have the mean weight of this step."""
    if 0.0 < weight < 1.0:
        return weight - 0.5 / release_ticks if start >= 0 else weight + 0.5 / release_ticks
    return weight


class RelativeMotion(NamedTuple):
    """Velocity of the second automaton of a pair relative to the first [m/s], and the mean of both spins [rad/s]."""

    vx: float
    vy: float
    spin: float


@internal_inlined
def relative_motion(place, motion, i, j):
    """Return the `RelativeMotion` of two automata."""
    p, q = place[i], place[j]
    return RelativeMotion(
        motion[VX, q] - motion[VX, p], motion[VY, q] - motion[VY, p], 0.5 * (motion[SPIN, p] + motion[SPIN, q])
    )


@internal_inlined
def sliding_speed(relative, nx, ny, r):
    """Return the sliding speed of the second automaton over the first, across the line of centres [m/s]."""
    return (relative.vy * nx - relative.vx * ny) - r * relative.spin


@internal_inlined
def _slip_increment(relative, x, y, r, time):
    """Return the slip of the second automaton over the first in a straight drift of `time` [s] to the present position [m].

    It is the mean of the slips across the lines of centres before and after, as kicks work along both; sums are second order.
    """
    old_x, old_y = x - time * relative.vx, y - time * relative.vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    before = 0.0 if old_r == 0.0 else sliding_speed(relative, old_x / old_r, old_y / old_r, old_r)
    return 0.5 * time * (before + sliding_speed(relative, x / r, y / r, r))


@internal_inlined
def _closure_work_error(relative, x, y, r, rest_before, overlap_after, time):
    """Return the work of kicks on a spring of stiffness 1 minus its energy change, if a pair closes or opens in a drift [m^2].

    The vector (x, y) from the first automaton to the second, its length `r` and `overlap_after` are those after the drift [m],
    which takes `time` [s].
    """
    old_x, old_y = x - time * relative.vx, y - time * relative.vy
    old_r = np.sqrt(old_x * old_x + old_y * old_y)
    overlap = rest_before - old_r
    if overlap_after > 0.0 and not overlap > 0.0:
        return 0.5 * overlap_after * (-time * (relative.vx * x + relative.vy * y) / r - overlap_after)
    if overlap > 0.0 and not overlap_after > 0.0 and old_r > 0.0:
        return -0.5 * overlap * (time * (relative.vx * old_x + relative.vy * old_y) / old_r - overlap)
    return 0.0


@internal
def contact_energy(medium, motion, contacts, row, slip_time):
    """Return the energy of a contact [J]; `slip_time` is the time for which it has slid since `slid` was recorded [s]."""
    layout, i, j = medium.body.layout, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
    x, y, r = separation(medium.contact_constants, layout.place, motion, i, j)
    overlap = contacts.rest[row] - r
    if not overlap > 0.0 or r == 0.0:
        return 0.0
    slid = contacts.slid[row]
    if slip_time > 0.0:
        slid += slip_time * sliding_speed(relative_motion(layout.place, motion, i, j), x / r, y / r, r)
    normal, tangential = contact_stiffnesses(medium.contact_constants, i, j)
    # A contact acts with the weight 1 - w, where w is the weight of its link.
    weight = 1.0 - link_weight(layout, medium.histories.weight, contacts.pairs, row)
    return 0.5 * weight * (normal * overlap * overlap + tangential * slid * slid)


@internal
def add_contact_forces(medium, motion, contacts, time, cells):
    """Add the forces of contacts to the automata in order, and update the slip; both forces of a pair are bitwise opposite.

    Args:
        medium: a `links.Medium`.
        motion: a `lattice.Motion`, with the velocities since the last force evaluation.
        contacts: `Contacts`, updated in place.
        time: since the last force evaluation [s]; 0 if forces are computed for outputs only.
        cells: of a `lattice.Scratch`; forces and torques are updated.

    Returns:
        The energies dissipated by friction, and by dashpots in addition to `dashpot_power` [J].
    """
    rubbed, damped, constants, layout = 0.0, 0.0, medium.contact_constants, medium.body.layout
    for row in range(contacts.used):
        i, j = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND]
        p, q = layout.place[i], layout.place[j]
        x, y, r = separation(constants, layout.place, motion, i, j)
        known, before = contacts.rest[row], contacts.slid[row]
        rest = min(medium.body.diameter, max(known, r))
        contacts.rest[row] = rest
        overlap = rest - r
        contacts.dashpot[row, 0] = contacts.dashpot[row, 1] = contacts.push[row] = 0.0
        if r == 0.0:
            contacts.slid[row] = 0.0
            continue
        weight = 1.0 - link_weight(layout, medium.histories.weight, contacts.pairs, row)
        relative = relative_motion(layout.place, motion, i, j)
        normal, tangential = contact_stiffnesses(constants, i, j)
        if constants.damping > 0.0 and time > 0.0:
            damped += weight * normal * _closure_work_error(relative, x, y, r, known, overlap, time)
        if before == 0.0 and not overlap > 0.0:
            continue
        slid = before + _slip_increment(relative, x, y, r, time)
        # A pair that has separated starts its next contact without slip.
        most = constants.friction * normal * max(overlap, 0.0) / tangential
        kept = min(max(slid, -most), most)
        # The kicks before and after the drift apply the mean of both forces; this mean times the released slip is dissipated.
        earlier = _weight_before_kick(medium.law.release, contacts.pairs[row, START], weight)
        rubbed += 0.5 * earlier * tangential * (before + kept) * (slid - kept)
        contacts.slid[row] = kept
        if not overlap > 0.0:
            continue
        nx, ny = x / r, y / r
        push, drag = weight * normal * overlap, weight * tangential * kept
        if constants.damping > 0.0:
            closing = -(relative.vx * nx + relative.vy * ny)
            one, other = medium.body.cells[MASS, p], medium.body.cells[MASS, q]
            mass = one * other / (one + other)
            more = max(2.0 * constants.damping * np.sqrt(weight * normal * mass) * closing, -push)
            contacts.dashpot[row, 0], contacts.dashpot[row, 1] = -more * nx, -more * ny
            push += more
        contacts.push[row] = push
        fx, fy = -push * nx - drag * ny, -push * ny + drag * nx
        cells[FORCE_X, p] += fx
        cells[FORCE_Y, p] += fy
        cells[FORCE_X, q] -= fx
        cells[FORCE_Y, q] -= fy
        cells[TORQUE, p] += 0.5 * r * drag
        cells[TORQUE, q] += 0.5 * r * drag
    return rubbed, damped


@internal
def dashpot_power(place, contacts, motion):
    """Return the power that dashpots dissipate [W] at these velocities with their current forces; `place` as in `Layout`."""
    power = 0.0
    for row in range(contacts.used):
        relative = relative_motion(place, motion, contacts.pairs[row, FIRST], contacts.pairs[row, SECOND])
        power += contacts.dashpot[row, 0] * relative.vx
        power += contacts.dashpot[row, 1] * relative.vy
    return power


# -- finding them -----------------------------------------------------------------------------------------------------------


def find_pairs(
    positions: FloatArray, automata: npt.NDArray[np.int64], reach: float, period: tuple[float, float]
) -> npt.NDArray[np.int64]:
    """Return the pairs of these automata that are closer than `reach`, first < second, sorted, shape (m, 2).

    Args:
        positions: of all automata, shape (n, 2) [m]; finite, and at most 2^30 `reach` from the origin.
        automata: automata to include, in increasing order, shape (k,).
        reach: search distance [m].
        period: of a periodic specimen along x and y, 0 if not periodic [m].
    """
    from scipy.spatial import cKDTree  # type: ignore[attr-defined]

    if not len(automata):
        return np.zeros((0, 2), np.int64)
    points, lengths = positions[automata], np.array(period)
    closed = lengths > 0.0
    points[:, closed] %= lengths[closed]
    # The modulo of a position just below 0 can be rounded to the whole period.
    points[:, closed] *= points[:, closed] < lengths[closed]
    pairs = cKDTree(points, boxsize=lengths).query_pairs(reach, output_type="ndarray")
    found = automata[np.sort(pairs.astype(np.int64), axis=1)]
    return found[np.lexsort(found.T[::-1])]


def is_within_search_range(positions: FloatArray, reach: float) -> bool:
    """Return whether all positions are finite and within the range of the search."""
    return bool((np.abs(positions) < _FARTHEST * reach).all())


def merge_contacts(
    known_contacts: tuple[npt.NDArray[np.int64], FloatArray, FloatArray],
    is_releasing: npt.NDArray[np.bool_],
    present_pairs: npt.NDArray[np.int64],
    count: int,
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Return the new contacts: pairs found by a search, and pairs whose link is being released; known pairs keep their slip.

    Args:
        known_contacts: `pairs`, `slid` and `rest` before the search, see `Contacts`, shapes (m, 4), (m,) and (m,).
        is_releasing: whether the link of each known pair is being released, shape (m,).
        present_pairs: pairs found by the search, as in `Contacts.pairs`, sorted, shape (k, 4).
        count: number of automata.
    """
    old_pairs, old_slid, old_rest = known_contacts
    keys, old_keys = present_pairs[:, 0] * count + present_pairs[:, 1], old_pairs[:, 0] * count + old_pairs[:, 1]
    is_releasing = is_releasing & ~np.isin(old_keys, keys)
    rows, keys = np.concatenate([present_pairs, old_pairs[is_releasing]]), np.concatenate([keys, old_keys[is_releasing]])
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
