"""Overlaps of gas cells with stations of the shell.

A station is a plane of shell nodes with the section of the tube that it represents. The overlaps of a gas cell with stations
together cover the part of the cell that lies in the shell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]
# Overlaps shorter than this fraction of a cell are rounding errors.
_ROUNDING = 1e-9


class Overlaps(NamedTuple):
    """The overlaps, station by station.

    Attributes:
        station: station of each overlap, shape (overlaps,).
        cell: gas cell of each overlap, shape (overlaps,).
        length: length of each overlap, shape (overlaps,) [m].
        offset: distance from cell centre to overlap centre, divided by the length of the cell, shape (overlaps,).
    """

    station: IntArray
    cell: IntArray
    length: FloatArray
    offset: FloatArray


class Interface(NamedTuple):
    """The overlaps, and the inner surface of the shell.

    Attributes:
        overlaps: overlaps of stations and cells.
        width: length of each station, shape (stations,) [m].
        nodes: nodes of the inner surface, station by station, shape (s,).
        share: weight of each of these nodes in the mean over its station, shape (s,).
        reference: positions of these nodes, shape (s, 3) [m].
        rest: distance of these nodes from the axis at rest, shape (s,) [m].
        area: initial cross-section of each gas cell, shape (cells,) [m^2].
    """

    overlaps: Overlaps
    width: FloatArray
    nodes: IntArray
    share: FloatArray
    reference: FloatArray
    rest: FloatArray
    area: FloatArray

    def to_stations(self, amounts: FloatArray) -> FloatArray:
        """Return for each station the sum of an amount over its overlaps, shape (stations,)."""
        return np.bincount(self.overlaps.station, amounts, minlength=len(self.width)).astype(np.float64)

    def to_cells(self, amounts: FloatArray) -> FloatArray:
        """Return for each gas cell the sum of an amount over its overlaps, shape (cells,)."""
        return np.bincount(self.overlaps.cell, amounts, minlength=len(self.area)).astype(np.float64)


def find_overlaps(bounds: FloatArray, cell_size: float, cells: int) -> Overlaps:
    """Return the overlaps of all stations with the gas cells.

    Args:
        bounds: ends of the stations in the coordinate of the gas, ascending, shape (stations + 1,) [m].
        cell_size: length of the gas cells; the first one begins at 0 [m].
        cells: number of cells.
    """
    rows = []
    for station, (low, high) in enumerate(zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True)):
        for number in range(max(int(low / cell_size) - 1, 0), min(int(high / cell_size) + 2, cells)):
            first, last = max(low, number * cell_size), min(high, (number + 1) * cell_size)
            if last - first > _ROUNDING * cell_size:
                offset = (0.5 * (first + last) - (number + 0.5) * cell_size) / cell_size
                rows.append((station, number, last - first, offset))
    station, cell, length, offset = np.array(rows).reshape(-1, 4).T.copy()
    return Overlaps(station.astype(np.int64), cell.astype(np.int64), length, offset)
