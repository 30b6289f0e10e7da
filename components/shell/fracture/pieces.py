"""Pieces of a cracked body, and the surfaces on which pressure still acts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...support.jit import internal, jit
from ..geometry.lattice import Lattice
from ..kernel_arrays import IntArray

# The four kinds of links of `facets.mark_cut_links`: along, across, and both diagonals.
ALONG, ACROSS = 0, 1
Marks = npt.NDArray[np.bool_]
# A node connects to a point if its shape function is larger: that of a direct neighbour is 0.04, across a corner 0.006.
_CONNECTS = 0.01


@jit
def label_columns(stencils, is_stressless, layers, labels, is_supported):
    """Write for each column of nodes the first column of its piece, i.e. the first one to which points connect it.

    A point that carries stress connects all columns with nodes in its support, except nodes with very small shape functions.

    Args:
        stencils: `Stencils` of the points.
        is_stressless: which points carry no stress, shape (m,).
        layers: number of nodes of a column.
        labels: written, shape (columns,).
        is_supported: written: whether any point supports each column, shape (columns,).
    """
    begin, nodes, values = stencils.begin, stencils.nodes, stencils.values
    for column in range(labels.size):
        labels[column], is_supported[column] = column, False
    for p in range(is_stressless.size):
        if is_stressless[p]:
            continue
        first, last, row = -1, -1, stencils.first[stencils.kind[p]]
        for entry in range(begin[p], begin[p + 1]):
            column = np.int64(nodes[entry]) // layers
            if column == last or not abs(values[row + entry - begin[p]]) > _CONNECTS:
                continue
            last = column
            is_supported[column] = True
            root = find_root(labels, column)
            if first < 0:
                first = root
            elif first < root:
                labels[root] = first
            else:
                labels[first] = root
                first = root
    for column in range(labels.size):
        labels[column] = find_root(labels, column)


@internal
def find_root(labels, column):
    """Return the first column of the piece of a column."""
    while labels[column] != column:
        column = labels[column]
    return column


def severed_links(links: npt.NDArray[np.uint8]) -> Marks:
    """Return which links of `facets.mark_cut_links` are cut through the whole wall, shape (columns, 4)."""
    return np.all(links > 0, axis=2)


def crack_lips(lattice: Lattice, is_severed: Marks) -> Marks:
    """Return the columns on both sides of cracks through the whole wall."""
    n, m, _ = lattice.shape
    lips = np.zeros((n, m), dtype=bool)
    for way, axis in ((ALONG, 0), (ACROSS, 1)):
        cut = is_severed[:, way].reshape(n, m).copy()
        if not lattice.axes[axis].is_closed:
            cut[(-1,) if axis == 0 else (slice(None), -1)] = False
        lips |= cut | np.roll(cut, 1, axis=axis)
    return lips.ravel()


def detached_columns(lattice: Lattice, is_severed: Marks, labels: IntArray) -> Marks:
    """Return the columns of detached pieces: all but the largest piece and, for a tube, pieces that form closed rings."""
    n, m, _ = lattice.shape
    held = {int(np.bincount(labels, minlength=n * m).argmax())}
    if lattice.axes[1].is_closed:
        rows = labels.reshape(n, m)
        whole = (rows == rows[:, :1]).all(axis=1) & ~is_severed[:, ACROSS].reshape(n, m).any(axis=1)
        held |= {int(one) for one in rows[whole, 0]}
    return ~np.isin(labels, sorted(held))
