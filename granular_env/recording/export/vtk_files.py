"""VTK files for ParaView, VisIt and PyVista: for each drawable a `.vtu` file per frame, and a `.pvd` file with the times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from ...components.drawables import Cells, Curve, Drawable, Links, Points, element_count, to_three_columns
from ...components.support.float_arrays import FloatArray
from ...optional_packages import import_optional
from ..element_arrays import cell_arrays, point_arrays
from ..event_places import event_place
from .frames import Frames
from .text_files import file_names, points_of, vector_rows, with_unit

if TYPE_CHECKING:
    from ..log import Log

# VTK's numbers of types of cells, by the number of points of a cell; other cells are polygons.
_CELL_TYPES, _POLYLINE, _POLYGON = {1: 1, 2: 3, 3: 5, 4: 9}, 4, 7
Arrays = Mapping[str, FloatArray]


class _Mesh(NamedTuple):
    """The geometry of a drawable in all frames: points (n, 3) [m], point indices of the cells (m, k), type of the cells.

    `rows` are the rows of the points in the array `displacement`; None if all points have their own row in this order.
    """

    points: FloatArray
    cells: npt.NDArray[np.int64]
    type: int
    displacement: str = ""
    rows: npt.NDArray[np.int64] | None = None


def write_vtk(frames: Frames, folder: Path) -> None:
    """Write a folder per drawable with a file per frame, the file that lists them, and the events."""
    vtk, log = import_optional("pyevtk.vtk", "export to VTK"), frames.log
    drawables = drawn_once(log)
    meshes = [_make_mesh(one, log) for one in drawables]
    folders = [folder / name for name in file_names(one.name for one in drawables)]
    written: list[tuple[str, float]] = []
    for own in folders:
        own.mkdir()
    for times, values in frames:
        for place, time in enumerate(times.tolist()):
            frame = {name: one[place] for name, one in values.items()}
            written.append((f"{len(written):06d}", time))
            for own, drawable, mesh in zip(folders, drawables, meshes, strict=True):
                _write_mesh(vtk, own / written[-1][0], mesh, *_frame_arrays(drawable, mesh, frame, log))
    for own in folders:
        group = vtk.VtkGroup(str(own))
        for name, time in written:
            group.addFile(str(own / f"{name}.vtu"), repr(time))
        group.save()
    _write_events(vtk, log, folder)


def drawn_once(log: Log) -> list[Drawable]:
    """Return the drawables with elements; curves along the same coordinate count once, because they share their arrays."""
    curves = {one.coordinate.tobytes(): replace(one, name="curves") for one in log.drawables if isinstance(one, Curve)}
    return [*(one for one in log.drawables if element_count(one)), *curves.values()]


def _make_mesh(drawable: Drawable, log: Log) -> _Mesh:
    match drawable:
        case Points():
            places = np.arange(len(drawable.radius))[:, np.newaxis]
            return _Mesh(to_three_columns(drawable.reference), places, _CELL_TYPES[1], drawable.displacement)
        case Cells():
            cells = drawable.connectivity
            return _Mesh(
                to_three_columns(drawable.nodes), cells, _CELL_TYPES.get(cells.shape[1], _POLYGON), drawable.displacement
            )
        case Curve():
            return _Mesh(to_three_columns(drawable.coordinate), np.arange(len(drawable.coordinate))[np.newaxis], _POLYLINE)
        case Links():
            ends = next(one for one in points_of(log) if one.name == drawable.points)
            # Each link has two separate points, because the second one lies across the edge if the body is periodic.
            first = to_three_columns(ends.reference)[drawable.pairs[:, 0]]
            points = np.stack([first, first + to_three_columns(ends.shortest_vectors(drawable.pairs))], axis=1).reshape(-1, 3)
            pairs = np.arange(len(points)).reshape(-1, 2)
            return _Mesh(points, pairs, _CELL_TYPES[2], ends.displacement, drawable.pairs.ravel())


def _frame_arrays(drawable: Drawable, mesh: _Mesh, frame: Arrays, log: Log) -> tuple[Arrays, Arrays]:
    """Return the arrays of a frame per point and per cell, by name with unit; displacements have three columns."""

    def labelled(names: list[str]) -> dict[str, FloatArray]:
        return {with_unit(name, log.variables[name].unit): vector_rows(frame[name]) for name in names if name in frame}

    of_points = labelled(point_arrays(drawable, log.variables))
    if isinstance(drawable, Points):
        of_points["radius [m]"] = drawable.radius
    if mesh.displacement in frame:
        moved = to_three_columns(frame[mesh.displacement])
        label = with_unit(mesh.displacement, log.variables[mesh.displacement].unit)
        of_points[label] = moved if mesh.rows is None else moved[mesh.rows]
    return of_points, labelled(cell_arrays(drawable, log.variables))


def _write_mesh(vtk: Any, path: Path, mesh: _Mesh, of_points: Arrays, of_cells: Arrays) -> None:
    """Write a `.vtu` file; `path` has no suffix."""
    file, (count, corners) = vtk.VtkFile(str(path), vtk.VtkUnstructuredGrid), mesh.cells.shape
    types = np.full(count, mesh.type, np.uint8)
    cells = {"connectivity": mesh.cells.ravel(), "offsets": np.arange(1, count + 1) * corners, "types": types}
    sections = {"Points": {"points": mesh.points}, "Cells": cells, "PointData": of_points, "CellData": of_cells}
    arrays = [np.ascontiguousarray(one) for content in sections.values() for one in content.values()]
    file.openGrid()
    file.openPiece(npoints=len(mesh.points), ncells=count)
    for section, content in sections.items():
        file.openElement(section)
        for name, array in content.items():
            escaped = quoteattr(name, {'"': "&quot;"})[1:-1]
            file.addHeader(escaped, array.dtype.name, len(array), array.size // max(len(array), 1))
        file.closeElement(section)
    file.closePiece()
    file.closeGrid()
    for array in arrays:
        file.appendHeader(array.dtype.name, array.size, 1)
        file.xml.stream.write(array.data)
    file.save()


def _write_events(vtk: Any, log: Log, folder: Path) -> None:
    """Write the events that have a place, at their initial positions: a file per kind of event."""
    for number, (kind, name) in enumerate(zip(log.event_kinds, file_names(log.event_kinds), strict=True)):
        detail = log.event_details.get(kind)
        placed = [(place, event) for event in log.events(kind) if (place := event_place(event.index, detail, log.drawables))]
        if placed:
            points = to_three_columns(np.array([place.position for place, _ in placed]))
            rows = [(one.tick * log.step_size, one.value, one.limit, one.index or 0, number) for _, one in placed]
            unit = detail.unit if detail is not None else ""
            labels = "time [s]", with_unit("value", unit), with_unit("limit", unit), "index", "kind"
            mesh = _Mesh(points, np.arange(len(placed))[:, np.newaxis], _CELL_TYPES[1])
            arrays = dict(zip(labels, np.array(rows, dtype=np.float64).T, strict=True))
            _write_mesh(vtk, folder / f"events-{name}", mesh, arrays, {})
