"""VTK files for ParaView, VisIt and PyVista: for each drawable a `.vtu` file per frame, and a `.pvd` file with the times."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from ...components.drawables import Cells, Curve, Links, Points, element_count, to_three_columns
from ...components.support.float_arrays import FloatArray
from ...optional_packages import import_optional
from ...output_files import valid_file_name
from ..element_arrays import element_arrays
from ..event_places import event_place
from .frames import Frames
from .text_files import vector_rows, with_unit

if TYPE_CHECKING:
    from ..log import Log

# VTK's numbers of types of cells, by the number of points of a cell; other cells are polygons.
_CELL_TYPES, _POLYGON = {1: 1, 2: 3, 3: 5, 4: 9}, 7
Solid = Points | Cells | Links
Arrays = Mapping[str, FloatArray]
# Points, shape (n, 3) [m], and the indices of the points of each cell, shape (m, k).
Mesh = tuple[FloatArray, npt.NDArray[np.int64]]


def write_vtk(frames: Frames, folder: Path) -> None:
    """Write a folder per drawable with a file per frame, the file that lists them, and the events."""
    vtk, log = import_optional("pyevtk.vtk", "export to VTK"), frames.log
    parts = []
    for drawable in solid_drawables(log):
        own = folder / valid_file_name(drawable.name, "unnamed")
        own.mkdir()
        parts.append((drawable, _make_mesh(drawable, log), own, vtk.VtkGroup(str(own))))
    for number, (time, frame) in enumerate(frames):
        for drawable, mesh, own, group in parts:
            _write_mesh(vtk, own / f"{number:06d}", mesh, *_frame_arrays(drawable, frame, log))
            group.addFile(str(own / f"{number:06d}.vtu"), repr(time))
    for *_, group in parts:
        group.save()
    _write_events(vtk, frames, folder)


def solid_drawables(log: Log) -> list[Solid]:
    """Return the drawables with recorded arrays, or all if none has any; without curves, whose values belong to cells."""
    found = [one for one in log.drawables if not isinstance(one, Curve) and element_count(one)]
    return [one for one in found if any(element_arrays(one, log.variables))] or found


def _make_mesh(drawable: Solid, log: Log) -> Mesh:
    match drawable:
        case Points():
            return to_three_columns(drawable.reference), np.arange(len(drawable.radius))[:, np.newaxis]
        case Cells():
            return to_three_columns(drawable.nodes), drawable.connectivity
        case Links():
            ends = _linked_points(drawable, log)
            # Each link has two separate points, because the second one lies across the edge if the body is periodic.
            first = to_three_columns(ends.reference)[drawable.pairs[:, 0]]
            points = np.stack([first, first + to_three_columns(ends.shortest_vectors(drawable.pairs))], axis=1).reshape(-1, 3)
            return points, np.arange(len(points)).reshape(-1, 2)


def _linked_points(links: Links, log: Log) -> Points:
    return next(one for one in log.drawables if isinstance(one, Points) and one.name == links.points)


def _frame_arrays(drawable: Solid, frame: Arrays, log: Log) -> tuple[Arrays, Arrays]:
    """Return the arrays of a frame per point and per cell, by name with unit; displacements have three columns."""
    of_points, of_cells = (
        {with_unit(name, log.variables[name].unit): vector_rows(frame[name]) for name in names if name in frame}
        for names in element_arrays(drawable, log.variables)
    )
    if isinstance(drawable, Points):
        of_points["radius [m]"] = drawable.radius
    moved = getattr(_linked_points(drawable, log) if isinstance(drawable, Links) else drawable, "displacement", "")
    if moved in frame:
        values = to_three_columns(frame[moved])
        values = values[drawable.pairs.ravel()] if isinstance(drawable, Links) else values
        of_points[with_unit(moved, log.variables[moved].unit)] = values
    return of_points, of_cells


def _write_mesh(vtk: Any, path: Path, mesh: Mesh, of_points: Arrays, of_cells: Arrays) -> None:
    """Write a `.vtu` file; `path` has no suffix."""
    file, (points, corners) = vtk.VtkFile(str(path), vtk.VtkUnstructuredGrid), mesh
    count, size = corners.shape
    types = np.full(count, _CELL_TYPES.get(size, _POLYGON), np.uint8)
    cells = {"connectivity": corners.ravel(), "offsets": np.arange(1, count + 1) * size, "types": types}
    sections = {"Points": {"points": points}, "Cells": cells, "PointData": of_points, "CellData": of_cells}
    file.openGrid()
    file.openPiece(npoints=len(points), ncells=count)
    for section, content in sections.items():
        file.openElement(section)
        for name, array in content.items():
            label = escape(name, {'"': "&quot;"})
            file.addHeader(label, array.dtype.name, len(array), array.size // max(len(array), 1))
        file.closeElement(section)
    file.closePiece()
    file.closeGrid()
    for array in (one for content in sections.values() for one in content.values()):
        file.appendHeader(array.dtype.name, array.size, 1)
        file.xml.stream.write(array.tobytes())
    file.save()


def _write_events(vtk: Any, frames: Frames, folder: Path) -> None:
    """Write the events in the time range that have a place, at their initial positions: a file per kind of event."""
    log = frames.log
    for kind, detail in log.event_details.items():
        events = [one for one in log.events(kind) if frames.first <= one.tick <= frames.last]
        if placed := [(place, one) for one in events if (place := event_place(one.index, detail, log.drawables))]:
            mesh = to_three_columns(np.array([place.position for place, _ in placed])), np.arange(len(placed))[:, np.newaxis]
            rows = [(one.tick * log.step_size, one.value, one.limit, one.index or 0) for _, one in placed]
            labels = "time [s]", with_unit("value", detail.unit), with_unit("limit", detail.unit), "index"
            arrays = dict(zip(labels, np.array(rows, dtype=np.float64).T, strict=True))
            _write_mesh(vtk, folder / f"events-{valid_file_name(kind, '')}", mesh, arrays, {})
