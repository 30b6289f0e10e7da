"""Finding the pairs that may touch, by cells: in the order of their automata, the same for the same positions.

Automata inside a whole piece are left out while its strains are small: they touch nothing but their neighbours.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit

# How much farther than contact pairs are looked for, in diameters; the list then holds until somebody has moved half of that.
SKIN = 0.3
# Cells farther out than this are not told apart any more.
_FARTHEST = 2.0**30


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
def slots_of_links(neighbours, weight, pairs, slot_out):
    """Write in which slot of the first automaton each pair is or was linked, -1 for none, -2 for one that holds.

    Args:
        neighbours: see `kernel_arrays.Body`, shape (n, slots).
        weight: see `link_histories.Bonds`, shape (n, slots).
        pairs: shape (m, 2).
        slot_out: shape (m,).
    """
    for row in range(pairs.shape[0]):
        first, second = pairs[row, 0], pairs[row, 1]
        slot_out[row] = -1
        for slot in range(neighbours.shape[1]):
            if neighbours[first, slot] == second:
                slot_out[row] = -2 if weight[first, slot] == 1.0 else slot


def merge(
    old_pairs: npt.NDArray[np.int64], old_slid: FloatArray, old_rest: FloatArray, pairs: npt.NDArray[np.int64],
    slots: npt.NDArray[np.int64], releasing: npt.NDArray[np.bool_], count: int,
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:  # fmt: skip
    """Return the contacts of now: the pairs that were found, and those whose link is being released, with what they know.

    Args:
        old_pairs: see `contact.Contacts`, shape (m, 4).
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
