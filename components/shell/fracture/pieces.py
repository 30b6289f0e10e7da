"""Pieces of a cracked body, and the surfaces on which pressure still acts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...support.jit import jit
from ..geometry.lattice import Lattice
from ..kernel_arrays import CompactArray, IndexArray, IntArray

# Ways of `facets.mark_links`: along, across, and both diagonals.
ALONG, ACROSS = 0, 1
Marks = npt.NDArray[np.bool_]
# A shape function that connects: that of a direct neighbour is 0.04, of one across a corner 0.006.
_CONNECTS = 0.01


class Connected(NamedTuple):
    """The columns of nodes that each point of a body without cracks connects.

    Attributes:
        ends: where those of each point end, shape (m + 1,), the first one 0.
        lowest: the one of each point that has the least number, shape (m,).
        offsets: the columns, counted from the lowest one of their point.
    """

    ends: IndexArray
    lowest: IndexArray
    offsets: CompactArray


@jit
def find_connected(stencils, layers, ends, columns):
    """Write the columns of which points of a body without cracks see a node, one point after the other.

    Args:
        stencils: `Stencils` of the points.
        layers: nodes of a column.
        ends: written: where those of each point end in `columns`, shape (m + 1,), the first one 0.
        columns: written, shape (entries,).
    """
    begin, lowest, offsets, values = stencils.begin, stencils.lowest, stencils.offsets, stencils.values
    count = 0
    for p in range(stencils.kind.size):
        last, row = -1, stencils.first[stencils.kind[p]]
        for entry in range(begin[p], begin[p + 1]):
            column = np.int64(lowest[p] + offsets[entry]) // layers
            if abs(values[row + entry - begin[p]]) > _CONNECTS and column != last:
                columns[count] = last = column
                count += 1
        ends[p + 1] = count


@jit
def label_columns(stencils, connected, blind, layers, shared, labels, borne):
    """Write for each column of nodes the first column that points connect with it.

    A point that bears stress connects all columns of which it sees a node, unless it hardly does.

    Args:
        stencils: `Stencils` of the points, with their cracks.
        connected: `Connected`.
        blind: which points bear nothing, shape (m,).
        layers: nodes of a column.
        shared: points of a smaller kind see what they saw before any crack.
        labels: written, shape (columns,).
        borne: written: whether any point sees each column, shape (columns,).
    """
    begin, lowest, offsets, kind = stencils.begin, stencils.lowest, stencils.offsets, stencils.kind
    first_rows, values = stencils.first, stencils.values
    ends, lowest_column, column_offsets = connected.ends, connected.lowest, connected.offsets
    for column in range(labels.size):
        labels[column], borne[column] = column, False
    for p in range(blind.size):
        if blind[p]:
            continue
        first, last = -1, -1
        plain = kind[p] < shared
        from_entry, to_entry = np.int64(begin[p]), np.int64(begin[p + 1])
        if plain:
            from_entry, to_entry = np.int64(ends[p]), np.int64(ends[p + 1])
        for entry in range(from_entry, to_entry):
            if plain:
                column = np.int64(lowest_column[p] + column_offsets[entry])
            else:
                if not abs(values[first_rows[kind[p]] + entry - begin[p]]) > _CONNECTS:
                    continue
                column = np.int64(lowest[p] + offsets[entry]) // layers
                if column == last:
                    continue
                last = column
            borne[column] = True
            second = column
            while labels[second] != second:
                second = labels[second]
            if first < 0:
                first = second
            elif first < second:
                labels[second] = first
            else:
                labels[first] = second
                first = second
    for column in range(labels.size):
        root = column
        while labels[root] != root:
            root = labels[root]
        labels[column] = root


def severed_links(links: npt.NDArray[np.uint8]) -> Marks:
    """Return which links of `facets.mark_links` are cut through the whole wall, shape (columns, 4)."""
    return np.all(links > 0, axis=2)


def crack_lips(lattice: Lattice, severed: Marks) -> Marks:
    """Return the columns beside cracks that go through the whole wall."""
    n, m, _ = lattice.shape
    lips = np.zeros((n, m), dtype=bool)
    for way, axis in ((ALONG, 0), (ACROSS, 1)):
        cut = severed[:, way].reshape(n, m).copy()
        if not lattice.axes[axis].closed:
            cut[(-1,) if axis == 0 else (slice(None), -1)] = False
        lips |= cut | np.roll(cut, 1, axis=axis)
    return lips.ravel()


def detached_columns(lattice: Lattice, severed: Marks, labels: IntArray) -> Marks:
    """Return the columns of detached pieces: all but the largest one, and of a tube those that close around nowhere."""
    n, m, _ = lattice.shape
    sizes = np.bincount(labels, minlength=n * m)
    held = {int(sizes.argmax())}
    if lattice.axes[1].closed:
        rows = labels.reshape(n, m)
        whole = (rows == rows[:, :1]).all(axis=1) & ~severed[:, ACROSS].reshape(n, m).any(axis=1)
        held |= {int(one) for one in rows[whole, 0]}
    return ~np.isin(labels, sorted(held))
