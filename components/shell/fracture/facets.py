"""Facets: the pieces of crack surface, one for each point that has parted, and what lies on either side of them.

A facet is the part of a plane, in the index space of the lattice, that lies in the cell of its point: half a spacing to each
side in the surface, and its share of the thickness. It runs beside the columns of nodes, not through them. A point and a node
do not see each other where the straight line between them crosses a facet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...events import MOST_INDEX
from ...state_block import Field
from ...support.float_arrays import FloatArray
from ...support.jit import internal_inlined, jit

# Neighbouring facets overlap by this [spacings].
_OVERLAP = 0.01
_HALF_CELL = 0.5


def facet_rows(points: int, shape: tuple[int, int, int]) -> Field:
    """Return facets in the state: point, middle, normal in index space, half the extent along the thickness, tick.

    Args:
        points: how many there are; each parts at most twice.
        shape: numbers of planes of nodes along the axes.
    """
    high = (points - 1, *shape, 1.0, 1.0, 1.0, shape[2], MOST_INDEX)
    return Field("f8", (9,), (0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, 0.0, 0), high, 2 * points)


class LatticeTable(NamedTuple):
    """The lattice as kernels want it.

    Attributes:
        across, layers: numbers of planes along the second axis and the third.
        period: planes around a closed second axis, 0 where it has ends.
        steps: distance of the nodes of each column through the thickness, in planes, shape (columns,).
    """

    across: int
    layers: int
    period: int
    steps: FloatArray


@internal_inlined
def crosses(facet, period, ax, ay, az, bx, by, bz):
    """Return whether the line from a to b crosses a facet; all in index space, a within half a period of the facet."""
    cx, cy, cz, nx, ny, nz = facet[1], facet[2], facet[3], facet[4], facet[5], facet[6]
    if period > 0:
        shift = round_to_period(cy - ay, period)
        ay, by = ay + shift, by + shift
    first = (ax - cx) * nx + (ay - cy) * ny + (az - cz) * nz
    second = (bx - cx) * nx + (by - cy) * ny + (bz - cz) * nz
    if (first > 0.0) == (second > 0.0):
        return False
    part = first / (first - second)
    x, y, z = ax + part * (bx - ax) - cx, ay + part * (by - ay) - cy, az + part * (bz - az) - cz
    half = _HALF_CELL + _OVERLAP
    return abs(x) <= half and abs(y) <= half and abs(z) <= facet[7] + _OVERLAP


@internal_inlined
def round_to_period(distance, period):
    """Return the whole number of periods that is nearest to a distance."""
    return period * np.floor(distance / period + 0.5)


@jit
def mark_hidden(facet, table, begin, lowest, offsets, places, points, hidden):
    """Mark the neighbours that some points lose to a facet, and return how many points lose one; those come first then.

    Args:
        facet: a row of `facet_rows`.
        table: `LatticeTable`.
        begin: where the neighbours of each point begin, shape (m + 1,).
        lowest: the neighbour of each point that has the least number, shape (m,).
        offsets: the neighbours, counted from the lowest one, shape (entries,).
        places: of the points that are near, shape (k, 3).
        points: their numbers, shape (k,); sorted anew, in place.
        hidden: marks of all entries, updated in place, shape (entries,).
    """
    count = 0
    for number in range(points.size):
        p = points[number]
        lost = False
        for entry in range(begin[p], begin[p + 1]):
            if not hidden[entry]:
                j = np.int64(lowest[p] + offsets[entry])
                x, y = j // (table.across * table.layers), j // table.layers % table.across
                z = float(j % table.layers) * table.steps[j // table.layers]
                around = float(y)
                if table.period > 0:
                    around += round_to_period(places[number, 1] - y, table.period)
                if crosses(facet, table.period, places[number, 0], places[number, 1], places[number, 2], float(x), around, z):
                    hidden[entry] = lost = True
        if lost:
            points[count] = p
            count += 1
    return count


@jit
def mark_links(facet, table, columns, links):
    """Mark the links between neighbouring columns that cross a facet.

    Args:
        facet: a row of `facet_rows`.
        table: `LatticeTable`.
        columns: which are near, shape (k,).
        links: 1 where cut, of each column with the ones after it along, after it across, and both ways diagonally, for each
            layer, updated in place, shape (columns, 4, layers).
    """
    along = links.shape[0] // table.across
    for number in range(columns.size):
        column = columns[number]
        a, b = column // table.across, column % table.across
        for way in range(4):
            x, y = a + (0 if way == 1 else 1), b + (0 if way == 0 else (-1 if way == 3 else 1))
            if x >= along or (table.period == 0 and (y < 0 or y >= table.across)):
                continue
            for layer in range(table.layers):
                z, other = layer * table.steps[column], layer * table.steps[x * table.across + y % table.across]
                if crosses(facet, table.period, float(a), float(b), z, float(x), float(y), other):
                    links[column, way, layer] = 1
