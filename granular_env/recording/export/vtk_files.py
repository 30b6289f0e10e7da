"""VTK files for ParaView, VisIt and PyVista: for each drawable a `.vtu` file per frame, and a `.pvd` file with the times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from ...components.drawables import Cells, Curve, Drawable, Links, Points, to_three_columns
from ...components.support.float_arrays import FloatArray
from ...optional_packages import import_optional
from ..element_arrays import cell_arrays, point_arrays, point_count
from ..event_places import event_place
from .frames import Frames
from .text_files import file_names, vector_rows, with_unit

if TYPE_CHECKING:
    from ..log import Log

_VERTEX, _LINE, _POLYLINE, _TRIANGLE, _POLYGON, _QUAD = 1, 3, 4, 5, 7, 9
_CELL_TYPES = {1: _VERTEX, 2: _LINE, 3: _TRIANGLE, 4: _QUAD}


class _Mesh(NamedTuple):
    """The geometry of a drawable in all frames.

    Attributes:
        points: initial positions, shape (n, 3) [m].
        cells: points of each cell, shape (m, k).
        type: VTK's number of the type of all cells.
        displacement: the output with the displacements; empty for none.
        point_names, cell_names: exported variables with an entry per point or per cell.
        fixed: arrays that do not change, shape (n,), by label.
        source: for each point its row in the arrays of `point_names` and of the displacement; None if they have the same order.
    """

    points: FloatArray
    cells: npt.NDArray[np.int64]
    type: int
    displacement: str
    point_names: list[str]
    cell_names: list[str]
    fixed: Mapping[str, FloatArray]
    source: npt.NDArray[np.int64] | None = None


def write_vtk(frames: Frames, folder: Path) -> None:
    """Write a folder per drawable with a file per frame, the file that lists them, and the events."""
    vtk = import_optional("pyevtk.vtk", "export to VTK")
    drawables = drawn_once(frames.log)
    meshes = dict(zip(file_names(one.name for one in drawables), [_make_mesh(one, frames) for one in drawables], strict=True))
    times: list[float] = []
    for name in meshes:
        (folder / name).mkdir()
    for block in frames:
        for place, time in enumerate(block.times):
            values = {name: one[place] for name, one in block.values.items()}
            for name, mesh in meshes.items():
                _write_mesh(vtk, _frame_path(folder, name, len(times)), mesh, *_frame_arrays(mesh, values, frames))
            times.append(float(time))
    for name in meshes:
        group = vtk.VtkGroup(str(folder / name))
        for number, time in enumerate(times):
            group.addFile(f"{_frame_path(folder, name, number)}.vtu", repr(time))
        group.save()
    _write_events(vtk, frames.log, folder)


def drawn_once(log: Log) -> list[Drawable]:
    """Return the drawables with elements; curves along the same coordinate count once, because they share their arrays."""
    found: dict[Any, Drawable] = {}
    for place, one in enumerate(log.drawables):
        if isinstance(one, Curve):
            found.setdefault(one.coordinate.tobytes(), replace(one, name="curves"))
        elif len(getattr(one, "pairs", ())) or point_count(one):
            found[place] = one
    return list(found.values())


def _frame_path(folder: Path, name: str, number: int) -> Path:
    return folder / name / f"{number:06d}"


def _make_mesh(drawable: Drawable, frames: Frames) -> _Mesh:
    """Return the geometry of a drawable and its exported variables."""
    variables = {name: frames.log.variables[name] for name in frames.names}
    names = point_arrays(drawable, variables), cell_arrays(drawable, variables)
    match drawable:
        case Points():
            single = np.arange(len(drawable.radius))[:, np.newaxis]
            points, radius = to_three_columns(drawable.reference), {"radius [m]": drawable.radius}
            return _Mesh(points, single, _VERTEX, drawable.displacement, *names, radius)
        case Cells():
            cells = drawable.connectivity
            type = _CELL_TYPES.get(cells.shape[1], _POLYGON)
            return _Mesh(to_three_columns(drawable.nodes), cells, type, drawable.displacement, *names, {})
        case Curve():
            line = np.arange(len(drawable.coordinate))[np.newaxis]
            return _Mesh(to_three_columns(drawable.coordinate), line, _POLYLINE, "", *names, {})
        case Links():
            ends = next(one for one in frames.log.drawables if isinstance(one, Points) and one.name == drawable.points)
            # Each link has two points of its own: the second one lies across the edge if the body is periodic.
            first = to_three_columns(ends.reference)[drawable.pairs[:, 0]]
            points = np.stack([first, first + to_three_columns(ends.shortest_vectors(drawable.pairs))], axis=1).reshape(-1, 3)
            pairs = np.arange(len(points)).reshape(-1, 2)
            return _Mesh(points, pairs, _LINE, ends.displacement, [], names[1], {}, drawable.pairs.ravel())


def _frame_arrays(mesh: _Mesh, values: Mapping[str, FloatArray], frames: Frames) -> tuple[dict[str, FloatArray], ...]:
    """Return the arrays of a frame per point and per cell, by label; displacements have three columns."""

    def select(names: list[str]) -> dict[str, FloatArray]:
        return {with_unit(name, frames.log.variables[name].unit): vector_rows(values[name]) for name in names}

    of_points = {**mesh.fixed, **select(mesh.point_names)}
    if mesh.displacement in values:
        moved = to_three_columns(values[mesh.displacement])
        label = with_unit(mesh.displacement, frames.log.variables[mesh.displacement].unit)
        of_points = {label: moved if mesh.source is None else moved[mesh.source]} | {
            name: one for name, one in of_points.items() if name != label
        }
    return of_points, select(mesh.cell_names)


def _write_mesh(
    vtk: Any, path: Path, mesh: _Mesh, of_points: Mapping[str, FloatArray], of_cells: Mapping[str, FloatArray]
) -> None:
    """Write a `.vtu` file; `path` has no suffix."""
    file, arrays = vtk.VtkFile(str(path), vtk.VtkUnstructuredGrid), list[np.ndarray]()

    def declare(name: str, array: np.ndarray) -> None:
        rows = array.reshape(len(array), -1)
        file.addHeader(escape(name, {'"': "&quot;"}), rows.dtype.name, *rows.shape)
        arrays.append(np.ascontiguousarray(rows))

    count, corners = mesh.cells.shape
    ends = np.arange(1, count + 1) * corners
    sections = {
        "Points": {"points": mesh.points},
        "Cells": {"connectivity": mesh.cells.ravel(), "offsets": ends, "types": np.full(count, mesh.type, np.uint8)},
        "PointData": of_points,
        "CellData": of_cells,
    }
    file.openGrid()
    file.openPiece(npoints=len(mesh.points), ncells=count)
    for section, content in sections.items():
        file.openElement(section)
        for name, array in content.items():
            declare(name, array)
        file.closeElement(section)
    file.closePiece()
    file.closeGrid()
    for array in arrays:
        file.appendHeader(array.dtype.name, *array.shape)
        file.xml.stream.write(array.data)
    file.save()


def _write_events(vtk: Any, log: Log, folder: Path) -> None:
    """Write the events that have a place, at their initial positions: a file per kind of event."""
    for number, (kind, name) in enumerate(zip(log.event_kinds, file_names(log.event_kinds), strict=True)):
        detail = log.event_details.get(kind)
        placed = [(place, event) for event in log.events(kind) if (place := event_place(event.index, detail, log.drawables))]
        if not placed:
            continue
        points = np.zeros((len(placed), 3))
        for row, (place, _) in enumerate(placed):
            points[row, : len(place.position)] = place.position
        unit = detail.unit if detail is not None else ""
        rows = np.array([(one.tick * log.step_size, one.value, one.limit) for _, one in placed])
        labels = "time [s]", with_unit("value", unit), with_unit("limit", unit)
        arrays = dict(zip(labels, rows.T, strict=True))
        arrays |= {"index": np.array([one.index for _, one in placed]), "kind": np.full(len(placed), number)}
        mesh = _Mesh(points, np.arange(len(placed))[:, np.newaxis], _VERTEX, "", [], [], {})
        _write_mesh(vtk, folder / f"events-{name}", mesh, arrays, {})
