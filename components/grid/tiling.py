"""Tiles of cells, the order in which a tick goes through a mesh: after each, the nodes whose last cell it held can move on.

So a mesh that does not fit the cache crosses it once in a tick. Parts of the mesh can be advanced side by side; the nodes on
the seam between them come last. The arithmetic of a node or a cell, and so the bits, depend on neither.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .kernel_arrays import IndexArray
from .mesh import IntArray

# Cells of a tile: corner forces of three tiles, 64 bytes a cell, fit a second-level cache of half a megabyte.
TILE_CELLS = 2048


class Schedule(NamedTuple):
    """The places of corner forces and the order of nodes; see `kernel_arrays.Grid`, and how many rows of scratch that takes."""

    slots: IndexArray
    node_slots: IndexArray
    further: IndexArray
    order: IndexArray
    tiles: IntArray
    parts: IntArray
    rows: int


def make_schedule(nodes: int, cells: IntArray, parts: int = 1) -> Schedule:
    """Return the order of the work for so many nodes and these cells, shape (m, 4), in so many parts."""
    m = len(cells)
    begins, first_tiles = _tile_begins(m, parts)
    count = len(begins) - 1
    tile = np.searchsorted(begins, np.arange(m), side="right") - 1
    part = np.searchsorted(first_tiles, tile, side="right") - 1
    last = _last_tile_of_nodes(nodes, cells, tile, part, seam=count)
    death = np.maximum.reduceat(last[cells].max(axis=1), begins[:-1])
    banks, bank_of_tile = _banks(death, first_tiles)
    slots = 4 * (bank_of_tile[tile] * TILE_CELLS + np.arange(m) - begins[tile])
    nothing = 4 * banks * TILE_CELLS
    node_slots, further = _corners_of_nodes(nodes, cells, slots, nothing)
    order = np.argsort(last, kind="stable")
    further = further[np.argsort(last[further[:, 0]], kind="stable")]
    # The tile after the last has no cells: its nodes are those of the seam.
    ends = np.arange(count + 2)
    tiles = np.stack(
        [
            np.append(begins, m),
            np.searchsorted(last[order], ends),
            np.searchsorted(last[further[:, 0]], ends),
        ],
        axis=1,
    )
    return Schedule(
        slots.astype(np.uint32), node_slots.astype(np.uint32), further.astype(np.uint32), order.astype(np.uint32),
        np.ascontiguousarray(tiles, dtype=np.int64), first_tiles, nothing + 1,
    )  # fmt: skip


def _tile_begins(cells: int, parts: int) -> tuple[IntArray, IntArray]:
    """Return the first cell of each tile, and the first tile of each part; both with the end behind."""
    begins: list[int] = []
    first_tiles = []
    for part in range(parts):
        first_tiles.append(len(begins))
        begins += range(cells * part // parts, cells * (part + 1) // parts, TILE_CELLS)
    return np.array([*begins, cells], dtype=np.int64), np.array([*first_tiles, len(begins)], dtype=np.int64)


def _last_tile_of_nodes(nodes: int, cells: IntArray, tile: IntArray, part: IntArray, seam: int) -> IntArray:
    """Return after which tile the force on each node is complete; `seam` for those between two parts, shape (n,)."""
    last, low, high = np.zeros(nodes, dtype=np.int64), np.full(nodes, len(cells)), np.full(nodes, -1)
    for corner in range(4):
        np.maximum.at(last, cells[:, corner], tile)
        np.minimum.at(low, cells[:, corner], part)
        np.maximum.at(high, cells[:, corner], part)
    return np.where(low == high, last, seam)


def _banks(death: IntArray, first_tiles: IntArray) -> tuple[int, IntArray]:
    """Return how many tiles have to be kept at a time, and the bank of each; `death`: after which tile it is not needed.

    Parts share no bank.
    """
    banks, total = np.zeros(len(death), dtype=np.int64), 0
    for begin, end in zip(first_tiles[:-1].tolist(), first_tiles[1:].tolist(), strict=True):
        free_after: list[int] = []
        for tile in range(begin, end):
            place = next((bank for bank, until in enumerate(free_after) if until < tile), len(free_after))
            if place == len(free_after):
                free_after.append(0)
            free_after[place] = int(death[tile])
            banks[tile] = total + place
        total += len(free_after)
    return total, banks


def _corners_of_nodes(nodes: int, cells: IntArray, slots: IntArray, nothing: int) -> tuple[IntArray, IntArray]:
    """Return the slots of each node by corner, and what is beyond one for each corner."""
    node_slots = np.full((nodes, 4), nothing, dtype=np.int64)
    beyond = []
    for corner in range(4):
        who, first = np.unique(cells[:, corner], return_index=True)
        node_slots[who, corner] = slots[first] + corner
        rest = np.ones(len(cells), dtype=bool)
        rest[first] = False
        beyond.append(np.stack([cells[rest, corner], slots[rest] + corner], axis=1))
    return node_slots, np.concatenate(beyond)
