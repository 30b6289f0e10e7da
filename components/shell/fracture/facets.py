"""Facets: plane pieces of crack surface, one for each cracked point, and the lines that they cross.

A facet is the part of a plane in index space (node numbers as coordinates) that lies in the cell of its point: half a spacing
to each side in the surface, and its share of the thickness. It runs between the columns of nodes, not through them. A node is
hidden from a point if the straight line between them crosses a facet.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...events import MOST_INDEX
from ...state_block import Field
from ...support.float_arrays import FloatArray
from ..geometry.lattice import Lattice
from ..kernel_arrays import IntArray
from .pieces import Marks

# Overlap of neighbouring facets [spacings].
_OVERLAP = 0.01
_HALF_CELL = 0.5
# Steps from a column to the next one along, across, and both ways diagonally.
_WAYS = ((1, 0), (0, 1), (1, 1), (1, -1))


def facet_declaration(points: int, shape: tuple[int, int, int]) -> Field:
    """Return the declaration of facets in the state: point; middle, normal, half extent through the wall in index space; tick.

    Args:
        points: number of points; each cracks at most twice.
        shape: numbers of planes of nodes along the axes.
    """
    high = (points - 1, *shape, 1.0, 1.0, 1.0, shape[2], MOST_INDEX)
    return Field("f8", (9,), (0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, 0.0, 0), high, 2 * points)


def crosses_facet(facet: FloatArray, period: int, a: FloatArray, b: FloatArray) -> Marks:
    """Return whether the straight lines from a to b cross a facet.

    Args:
        facet: a row of `facet_declaration`.
        period: planes around a closed second axis, 0 for an axis with ends.
        a: places in index space, each within half a period of b, shape (k, 3).
        b: places in index space, shape (k, 3).
    """
    middle, normal = facet[1:4], facet[4:7]
    if period > 0:
        shift = np.zeros_like(a)
        shift[:, 1] = nearest_period_multiple(middle[1] - a[:, 1], period)
        a, b = a + shift, b + shift
    # Summed term by term, because a sum along an array axis has no fixed order.
    first, second = (
        (one[:, 0] - middle[0]) * normal[0] + (one[:, 1] - middle[1]) * normal[1] + (one[:, 2] - middle[2]) * normal[2]
        for one in (a, b)
    )
    apart = (first > 0.0) != (second > 0.0)
    part = first / np.where(apart, first - second, 1.0)
    x, y, z = (a + part[:, None] * (b - a) - middle).T
    half = _HALF_CELL + _OVERLAP
    return apart & (np.abs(x) <= half) & (np.abs(y) <= half) & (np.abs(z) <= facet[7] + _OVERLAP)


def nearest_period_multiple(distance: FloatArray, period: int) -> FloatArray:
    """Return the multiple of the period nearest to each distance."""
    return period * np.floor(distance / period + 0.5)


def mark_cut_links(facet: FloatArray, lattice: Lattice, columns: IntArray, links: npt.NDArray[np.uint8]) -> None:
    """Mark the links between neighbouring columns that cross a facet.

    Args:
        facet: a row of `facet_declaration`.
        lattice: of the nodes.
        columns: nearby columns, shape (k,).
        links: 1 for a cut link of each column with the ones after it along, after it across, and both ways diagonally, for each
            layer, updated in place, shape (columns, 4, layers).
    """
    along, across, layers = lattice.shape
    closed, layer = lattice.axes[1].is_closed, np.tile(np.arange(layers), len(columns))
    column = np.repeat(columns, layers)
    x, y = column // across, column % across
    own = np.stack([x, y, layer * lattice.layer_steps[column]], axis=1).astype(np.float64)
    for way, (dx, dy) in enumerate(_WAYS):
        there = (x + dx < along) & (closed | ((y + dy >= 0) & (y + dy < across)))
        other = ((x + dx) * across + (y + dy) % across)[there]
        ends = np.stack([(x + dx)[there], (y + dy)[there], layer[there] * lattice.layer_steps[other]], axis=1)
        cut = crosses_facet(facet, across if closed else 0, own[there], ends.astype(np.float64))
        links[column[there][cut], way, layer[there][cut]] = 1
