"""Automata that overlap cells of the grid, cut as their packing cuts them: what lies in both would have its mass twice.

An automaton is made of sectors, triangles about its centre of which the packing keeps those inside the shape. Sectors and cells
are convex: two of them overlap unless a line along a side of one of the two has the other one beyond it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..automata.packing import Packing, hole_misfits
from ..automata.shapes import ON_THE_OUTLINE, Shape
from ..errors import Fault, ParameterError
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray, norms
from .places import Places, common_sides

# Nodes may stand as far off the outline, and each automaton off its node: sectors that overlap by less meet, in diameters.
_MEETING = 2.0 * ON_THE_OUTLINE
# An origin that lies farther off than this is not what was meant, in how far the automata reach into cells.
_FARTHEST = 3.0
# How many pairs of cells and automata are compared at once: a bound of the memory.
_AT_ONCE = 20_000


class Overlaps(NamedTuple):
    """Sectors of automata that overlap cells; of a sector in several cells, each.

    Attributes:
        cells: shape (k,).
        automata: shape (k,).
        reach: how far the sector would have to move across a side of the cell to leave it, shape (k,) [m].
        shifts: how far automata would have to move along +x, -x, +y and -y to leave the cells that they overlap, (4,) [m].
    """

    cells: IntArray
    automata: IntArray
    reach: FloatArray
    shifts: FloatArray


def find_overlaps(corners: FloatArray, packing: Packing, places: Places) -> Overlaps:
    """Return where automata overlap cells.

    Args:
        corners: of the cells, counter-clockwise and convex, shape (m, 4, 2) [m].
        packing: the automata.
        places: these by their place.
    """
    cells, automata, centres = _near_pairs(corners, packing, places)
    found = [
        _overlaps_of_pairs(cells[some], automata[some], centres[some], corners, packing, places) for some in _slices(len(cells))
    ]
    return Overlaps(
        np.concatenate([one.cells for one in found]),
        np.concatenate([one.automata for one in found]),
        np.concatenate([one.reach for one in found]),
        np.max([one.shifts for one in found], axis=0),
    )


def refuse_overlaps(mesh: Mesh, packing: Packing, places: Places, shape: Shape, origin: FloatArray) -> None:
    """Refuse automata that overlap cells, with the deepest of them and with what would fit, where that is known."""
    corners = mesh.nodes[mesh.cells]
    found = find_overlaps(corners, packing, places)
    if not len(found.cells):
        return
    # The first of those that are equal to rounding.
    deepest = int(np.argmax(found.reach > (1.0 - ON_THE_OUTLINE) * found.reach.max()))
    cell, automaton = int(found.cells[deepest]), int(found.automata[deepest])
    inside = packing.reference[automaton]
    (x, y), (u, v) = (inside + origin).tolist(), mesh.centres[cell].tolist()
    fitting = _fitting_origin(mesh, corners, packing, places, shape, origin, found)
    advice = f"move `origin` to {fitting}" if fitting else "move `origin`, let the shape of the automata end at sides of cells"
    raise ParameterError(
        Fault(
            ("automata",),
            f"{len(np.unique(found.automata))} automata reach up to {found.reach[deepest]:.6g} m into cells of the grid: "
            f"automaton {automaton} at ({x:.9g}, {y:.9g}) m into cell {cell}, about ({u:.9g}, {v:.9g}) m",
            "parts that meet in sides of cells alone",
            f"{advice}, or leave a hole in the mesh there",
        ),
        *(fault.within("automata") for fault in hole_misfits(packing, shape, *inside.tolist())),
    )


def _slices(count: int) -> list[slice]:
    """Return slices that make up so many pairs, at least one."""
    return [slice(first, first + _AT_ONCE) for first in range(0, max(count, 1), _AT_ONCE)]


def _near_pairs(corners: FloatArray, packing: Packing, places: Places) -> tuple[IntArray, IntArray, FloatArray]:
    """Return cells and automata that may overlap, and where the centre of each of these is, shape (k,), (k,) and (k, 2) [m]."""
    outer = packing.diameter * float(norms(packing.lattice.sectors).max())
    middles = corners.mean(axis=1)
    reach = outer + norms(corners - middles[:, np.newaxis]).max(axis=1)
    candidates = np.flatnonzero(places.may_be_near(middles, reach))
    cell, automaton, centre = places.near(middles[candidates], reach[candidates])
    cell = candidates[cell]
    inward = [_inward(corners[cell[some]], centre[some, np.newaxis]).min(axis=1) for some in _slices(len(cell))]
    kept = np.concatenate(inward) > -outer
    return cell[kept], automaton[kept], centre[kept]


def _overlaps_of_pairs(
    cells: IntArray, automata: IntArray, centres: FloatArray, corners: FloatArray, packing: Packing, places: Places
) -> Overlaps:
    """Return the overlaps of pairs of a cell and an automaton with this centre."""
    pair, sector = np.nonzero(packing.sectors[automata])
    triangles = centres[pair, np.newaxis] + packing.diameter * packing.lattice.sectors[sector]
    # What sticks out of a side that is closed on itself lies at the opposite one.
    kept = places.are_within_period(triangles.mean(axis=1))
    pair, triangles = pair[kept], triangles[kept]
    around = corners[cells[pair]]
    reach = _inward(around, triangles).min(axis=1)
    deep = np.minimum(reach, _inward(triangles, around).min(axis=1)) > _MEETING * packing.diameter
    pair, triangles, around = pair[deep], triangles[deep], around[deep]
    (low, high), (begin, end) = ((one.min(axis=1), one.max(axis=1)) for one in (triangles, around))
    along = np.stack([end - low, high - begin], axis=2).reshape(-1, 4)
    return Overlaps(cells[pair], automata[pair], reach[deep], along.max(axis=0, initial=0.0))


def _inward(polygons: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far inside of each side of counter-clockwise polygons the innermost point lies, shape (k, sides) [m].

    Args:
        polygons: shape (k, sides, 2) [m].
        points: those of each polygon, shape (k, points, 2) [m].
    """
    way = np.roll(polygons, -1, axis=1) - polygons
    normal = np.stack([-way[..., 1], way[..., 0]], axis=2) / norms(way)[..., np.newaxis]
    # Differences first: a body may lie far off the origin.
    offset = points[:, np.newaxis] - polygons[:, :, np.newaxis]
    return (offset[..., 0] * normal[..., 0, np.newaxis] + offset[..., 1] * normal[..., 1, np.newaxis]).max(axis=2)


def _fitting_origin(
    mesh: Mesh, corners: FloatArray, packing: Packing, places: Places, shape: Shape, origin: FloatArray, found: Overlaps
) -> str:
    """Return the nearest origin along x or y at which the parts meet and do not overlap; empty where none is near."""
    ways = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    for number in np.argsort(found.shifts, kind="stable").tolist():
        shift = found.shifts[number] * ways[number]
        sides = common_sides(mesh, shape, origin + shift)
        if found.shifts[number] > _FARTHEST * found.reach.max() or not len(sides):
            continue
        meeting = places.is_at(places.find(mesh.nodes[sides.reshape(-1)] - shift)[1]).all()
        if meeting and not len(find_overlaps(corners - shift, packing, places).cells):
            x, y = (origin + shift).tolist()
            return f"[{x:.9g}, {y:.9g}]"
    return ""
