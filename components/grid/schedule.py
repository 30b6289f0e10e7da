"""The order of the work on a mesh: tiles of cells, after each of which the nodes whose last cell it held can move on.

So a mesh that does not fit the cache crosses it once in a tick. The arithmetic of a node or a cell, and so the bits, do not
depend on the tiles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .layout import IndexArray
from .mesh import IntArray

# Cells of a tile: corner forces of three tiles, 64 bytes a cell, fit a second-level cache of half a megabyte.
TILE_CELLS = 2048


class Schedule(NamedTuple):
    """Where corner forces lie and in which order nodes come; see `layout.Grid`, and how many rows of scratch that takes."""

    slots: IndexArray
    node_slots: IndexArray
    further: IndexArray
    order: IndexArray
    tiles: IntArray
    rows: int


def make_schedule(nodes: int, cells: IntArray) -> Schedule:
    """Return the order of the work for so many nodes and these cells, shape (m, 4)."""
    m, tile_cells = len(cells), TILE_CELLS
    tile = np.arange(m) // tile_cells
    count = int(tile[-1]) + 1
    last = np.zeros(nodes, dtype=np.int64)
    for corner in range(4):
        np.maximum.at(last, cells[:, corner], tile)
    banks, bank_of_tile = _banks(np.maximum.reduceat(last[cells].max(axis=1), np.arange(count) * tile_cells))
    slots = 4 * (bank_of_tile[tile] * tile_cells + np.arange(m) % tile_cells)
    nothing = 4 * banks * tile_cells
    node_slots, further = _corners_of_nodes(nodes, cells, slots, nothing)
    order = np.argsort(last, kind="stable")
    further = further[np.argsort(last[further[:, 0]], kind="stable")]
    tiles = np.stack(
        [
            np.minimum(np.arange(count + 1) * tile_cells, m),
            np.searchsorted(last[order], np.arange(count + 1)),
            np.searchsorted(last[further[:, 0]], np.arange(count + 1)),
        ],
        axis=1,
    )
    return Schedule(
        slots.astype(np.uint32), node_slots.astype(np.uint32), further.astype(np.uint32), order.astype(np.uint32),
        np.ascontiguousarray(tiles, dtype=np.int64), nothing + 1,
    )  # fmt: skip


def _banks(death: IntArray) -> tuple[int, IntArray]:
    """Return how many tiles have to be kept at a time, and the bank of each; `death`: after which tile it is not needed."""
    free_after: list[int] = []
    banks = np.zeros(len(death), dtype=np.int64)
    for tile, end in enumerate(death.tolist()):
        place = next((bank for bank, until in enumerate(free_after) if until < tile), len(free_after))
        if place == len(free_after):
            free_after.append(0)
        free_after[place] = end
        banks[tile] = place
    return len(free_after), banks


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
