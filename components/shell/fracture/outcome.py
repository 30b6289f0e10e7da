"""The outcome for a body in one word, and the extent of its cracks along and around it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...support.float_arrays import FloatArray
from ..geometry.lattice import Lattice
from ..kernel_arrays import IntArray
from .pieces import Marks

OUTCOMES = ("whole", "bulged", "axial crack", "hoop crack", "severed")
WHOLE, BULGED, AXIAL, HOOP, SEVERED = range(5)
# A wall has bulged, i.e. its girth has grown for good, if the mean plastic strain over a station (points around) exceeds this.
BULGED_STRAIN = 0.002
# A crack that covers a smaller fraction of the circumference at a station, or fewer sides of columns, is no hoop crack: a crack
# along the body may be offset by a column or two.
_TURNED, _TURNED_SIDES = 0.05, 3


class CutSides(NamedTuple):
    """The sides of columns that a crack cuts from the next column.

    Attributes:
        along: whether a column is cut from the next one along the body, shape (n, m); the crack then runs around the body.
        across: whether a column is cut from the next one around the body, shape (n, m); the crack then runs along the body.
    """

    along: Marks
    across: Marks

    @property
    def is_cut(self) -> bool:
        """Return whether any side is cut."""
        return bool(self.along.any() or self.across.any())


def axial_crack_extent(lattice: Lattice, cut_sides: CutSides) -> float:
    """Return the extent of cracks along the body, from the first station to the last [m]; 0 if none runs along it."""
    stations = np.flatnonzero(cut_sides.across.any(axis=1))
    return float(np.ptp(lattice.axes[0].positions[stations])) if len(stations) else 0.0


def circumferential_crack_part(lattice: Lattice, cut_sides: CutSides) -> float:
    """Return the largest fraction of the circumference, or of the width of a plate, that one crack takes at one station."""
    return float(_crack_extents(lattice, cut_sides)[0].max(initial=0.0))


def _crack_extents(lattice: Lattice, cut_sides: CutSides) -> tuple[FloatArray, IntArray]:
    """Return for each crack at each station: the fraction of the circumference that it covers, and its number of sides."""
    widths = lattice.axes[1].widths
    station, column = np.nonzero(cut_sides.along)
    if not len(station):
        return np.zeros(0), np.zeros(0, np.int64)
    # Only existing pairs are listed: a table of all stations and cracks would take more memory than the state.
    _, part = np.unique(_crack_labels(lattice, cut_sides) * len(cut_sides.along) + station, return_inverse=True)
    return np.bincount(part, widths[column]) / widths.sum(), np.bincount(part)


def _crack_labels(lattice: Lattice, cut_sides: CutSides) -> IntArray:
    """Return the crack number of each cut side of `CutSides.along`; cracks join at corners, halfway between four columns."""
    n, m = cut_sides.along.shape
    corners = m if lattice.axes[1].is_closed else m + 1
    ends = []
    for sides, first, second in ((cut_sides.along, (1, 0), (1, 1)), (cut_sides.across, (0, 1), (1, 1))):
        station, column = np.nonzero(sides)
        ends.append([(station + i) * corners + (column + j) % corners for i, j in (first, second)])
    one, other = np.concatenate(ends, axis=1)
    met = coo_array((np.ones(len(one)), (one, other)), shape=2 * ((n + 1) * corners,))
    _, labels = connected_components(met, directed=False)
    return labels[ends[0][0]].astype(np.int64)


def connects_ends(labels: IntArray, is_supported: Marks, shape: tuple[int, int]) -> bool:
    """Return whether a piece reaches from the first station to the last.

    `labels` has the number of the piece of each of the n m columns; `is_supported` says whether a point supports it.
    """
    rows, bearing = labels.reshape(shape), is_supported.reshape(shape)
    return bool(np.isin(rows[0][bearing[0]], rows[-1][bearing[-1]]).any())


def outcome(lattice: Lattice, cut_sides: CutSides, is_severed: bool, plastic_strain: FloatArray) -> int:
    """Return the number of the outcome in `OUTCOMES`.

    Args:
        lattice: of the nodes.
        cut_sides: sides of the columns that cracks cut.
        is_severed: whether no piece reaches from one end of the body to the other any more.
        plastic_strain: mean plastic strain at each station, i.e. row of points around the body, shape (stations,).
    """
    if is_severed:
        return SEVERED
    if not cut_sides.is_cut:
        return BULGED if float(plastic_strain.max(initial=0.0)) > BULGED_STRAIN else WHOLE
    parts, sides = _crack_extents(lattice, cut_sides)
    turned = (parts >= _TURNED) & (sides >= min(_TURNED_SIDES, lattice.shape[1] / 2))
    return HOOP if turned.any() or not cut_sides.across.any() else AXIAL
