"""The order in which a sweep goes through a linked packing, in parts for threads, and the ring buffers between its stages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from .kernel_arrays import Body

# Numbers of the longest vectors that loops are made of: what is kept in tiles is computed in whole ones.
VECTOR = 8
# Automata of a tile, and the distance of its rows: a vector may reach beyond a tile's end; and not a power of two, whose rows
# would compete for places in the cache.
SHIFT = 8
LANES, STRIDE = 1 << SHIFT, (1 << SHIFT) + VECTOR
# Rows of a tile: of automata (displacement x and y in diameters, cos - 1 and sin of half the rotation, volumetric strain); of
# each pair (strains along and across, direction x and y); of what each pair does (force x and y, torque).
POINT_ROWS, LINK_ROWS, PULL_ROWS = 5, 4, 3
# How many neighbours' neighbours' ... the work on an automaton needs at each of its stages: moved, strained, dilated, pulled.
_DEPTHS = (4, 3, 2, 1)


class Part(NamedTuple):
    """Automata that one thread advances, the order of the work on them, and the rings.

    Attributes:
        begin: the first of them.
        end: after the last of them.
        runs: first automaton of each run (neighbours in memory of one kind, whose neighbours lie equally far on), and how many
            automata there are, shape (runs + 1,).
        kinds: row of each run in the tables of the body, shape (runs,).
        offsets: how far on in memory the neighbours of a run lie, 0 where there is none, shape (runs, slots).
        lags: how far each of five stages is behind the first one, whole tiles.
        ranges: first automaton and end of each of five stages: neighbours of this part's automata are computed too,
            shape (5, 2).
        last: number of the last tile of a ring; rings have 2^k tiles.
        passed: scratch: which run each stage has come to, shape (5,).
        points: ring of automata.
        links: ring of pairs.
        pulls: ring of what pairs do.
        sums: forces and torques of a tile.
        ghost_displacement: of the neighbours that belong to other parts, those before and those behind, shape (2 g,) [m].
        ghost_velocity: likewise [m/s].
        ghost_rotation: likewise, shape (g,) [rad].
        ghost_spin: likewise [rad/s].
    """

    begin: int
    end: int
    runs: npt.NDArray[np.int64]
    kinds: npt.NDArray[np.int64]
    offsets: npt.NDArray[np.int64]
    lags: npt.NDArray[np.int64]
    ranges: npt.NDArray[np.int64]
    last: int
    passed: npt.NDArray[np.int64]
    points: FloatArray
    links: FloatArray
    pulls: FloatArray
    sums: FloatArray
    ghost_displacement: FloatArray
    ghost_velocity: FloatArray
    ghost_rotation: FloatArray
    ghost_spin: FloatArray


def make_part(body: Body) -> Part:
    """Return a packing as one part."""
    runs, kinds, offsets = _find_runs(body)
    return _make_part(runs, kinds, offsets, int(np.abs(offsets).max(initial=0)), 0, len(body.kind))


def _find_runs(body: Body) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    offsets = body.neighbours.astype(np.int64) - np.arange(len(body.kind))[:, np.newaxis]
    changes = (offsets[1:] != offsets[:-1]).any(axis=1) | (body.kind[1:] != body.kind[:-1])
    first = np.concatenate([[0], np.flatnonzero(changes) + 1]).astype(np.int64)
    return np.append(first, len(body.kind)), body.kind[first].astype(np.int64), np.ascontiguousarray(offsets[first])


def _make_part(
    runs: npt.NDArray[np.int64], kinds: npt.NDArray[np.int64], offsets: npt.NDArray[np.int64], reach: int, begin: int, end: int
) -> Part:
    half, count = offsets.shape[1] // 2, int(runs[-1])
    # A stage waits until neighbours that come later in memory have passed the one before.
    ahead, behind = (_whole_tiles(int(slots.max(initial=0))) for slots in (offsets[:, :half], offsets[:, half:]))
    lags = np.cumsum([0, ahead, behind, ahead, behind]).astype(np.int64)
    ranges = np.array([[max(begin - depth * reach, 0), min(end + depth * reach, count)] for depth in (*_DEPTHS, 0)], np.int64)
    # What a stage leaves in a ring is needed for the last time when that stage is so far ahead.
    tiles = 1 << ((ahead + behind) // LANES).bit_length()
    ghosts, row = int(begin - ranges[0, 0] + ranges[0, 1] - end), tiles * STRIDE
    return Part(
        begin, end, runs, kinds, offsets, lags, ranges, tiles - 1, np.zeros(5, np.int64),
        np.zeros(POINT_ROWS * row), np.zeros(LINK_ROWS * half * row), np.zeros(PULL_ROWS * half * row),
        np.zeros(3 * STRIDE), np.zeros(2 * ghosts), np.zeros(2 * ghosts), np.zeros(ghosts), np.zeros(ghosts),
    )  # fmt: skip


def _whole_tiles(length: int) -> int:
    return -(-length // LANES) * LANES
