"""Text formats: tables of histories (CSV) and particles frame by frame (extended XYZ). Numbers keep all their bits."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

import numpy as np

from ...components.drawables import Points, to_three_columns
from ...components.support.float_arrays import FloatArray
from ...components.variables import index_text
from ...output_files import valid_file_name
from ...terminal_text import printable_text
from ..element_arrays import point_arrays
from .frames import Frames

if TYPE_CHECKING:
    from ..log import Log

# The chemical symbol of particles that are no atoms is X. Rows of an XYZ file that are formatted together.
_ROWS = 10_000


def with_unit(name: str, unit: str) -> str:
    """Return the name of a column or an array with its unit, such as "velocity [m/s]"."""
    return printable_text(f"{name} [{unit}]" if unit not in ("", "1") else name)


def write_csv(frames: Frames, path: Path) -> None:
    """Write one row per frame: the time, then each number of each variable."""
    heads = ["time [s]"]
    for name in frames.names:
        variable = frames.log.variables[name]
        elements = [f"{name}[{index_text(index)}]" if index else name for index in np.ndindex(variable.shape)]
        heads += [with_unit(element, variable.unit) for element in elements]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        for block in frames:
            columns = [one.reshape(len(block.times), -1) for one in block.values.values()]
            writer.writerows(np.hstack([block.times[:, np.newaxis], *columns]).tolist())


def write_xyz(frames: Frames, path: Path) -> None:
    """Write a file or, for several sets of points, a folder with one file per set."""
    points = points_of(frames.log)
    paths = [path / f"{name}.xyz" for name in file_names(one.name for one in points)] if len(points) > 1 else [path]
    files = [one.open("w", encoding="utf-8") for one in paths]
    try:
        particles = [_Particles.of(one, frames) for one in points]
        for block in frames:
            for place, time in enumerate(block.times):
                values = {name: one[place] for name, one in block.values.items()}
                for file, one in zip(files, particles, strict=True):
                    one.write(file, time, values)
    finally:
        for file in files:
            file.close()


def points_of(log: Log) -> list[Points]:
    """Return the points among the drawables of a log."""
    return [one for one in log.drawables if isinstance(one, Points)]


def file_names(names: Iterable[str]) -> list[str]:
    """Return a different file name for each name, with characters that are valid everywhere."""
    found: list[str] = []
    for one in names:
        name = valid_file_name(one, "unnamed")
        found.append(name if name not in found else f"{name}-{len(found)}")
    return found


def vector_rows(values: FloatArray) -> FloatArray:
    """Return the entries of each element as a row; vectors in a plane get a third component 0."""
    rows = values.reshape(len(values), -1)
    return to_three_columns(rows) if rows.shape[1] == 2 else rows


class _Particles(NamedTuple):
    """A set of points, with the text that is the same in all frames.

    Attributes:
        points: the points.
        head: the comment line up to the time.
        row: format of a row.
        names: the exported variables.
    """

    points: Points
    head: str
    row: str
    names: list[str]

    @classmethod
    def of(cls, points: Points, frames: Frames) -> _Particles:
        variables = {name: frames.log.variables[name] for name in frames.names}
        names = point_arrays(points, variables)
        columns = [("pos", 3, "m"), ("radius", 1, "m")]
        for name in names:
            size = prod(variables[name].shape[1:])
            columns.append((_word(name), 3 if size == 2 else size, variables[name].unit))
        properties = ":".join(["species:S:1", *(f"{name}:R:{width}" for name, width, _ in columns)])
        units = ", ".join(f"{name} {_word(unit, '/^-')}" for name, _, unit in columns)
        row = " ".join(["X", *["%.17g"] * sum(width for _, width, _ in columns)])
        return cls(
            points, f'{_cell(points)}name="{_word(points.name)}" Properties={properties} units="{units}"', f"{row}\n", names
        )

    def write(self, file: TextIO, time: float, values: Mapping[str, FloatArray]) -> None:
        """Write one frame."""
        positions = to_three_columns(self.points.reference)
        if self.points.displacement in values:
            positions = positions + to_three_columns(values[self.points.displacement])
        columns = [positions, self.points.radius[:, np.newaxis], *(vector_rows(values[name]) for name in self.names)]
        file.write(f"{len(positions)}\n{self.head} Time={float(time)!r}\n")
        for begin in range(0, len(positions), _ROWS):
            part = np.hstack([one[begin : begin + _ROWS] for one in columns])
            file.write(self.row * len(part) % tuple(part.ravel().tolist()))


def _word(text: str, others: str = "") -> str:
    """Return a text without characters that have a meaning in the format."""
    return re.sub(rf"[^\w{others}]+", "_", text) or "_"


def _cell(points: Points) -> str:
    """Return the box of periodic points; along other axes it encloses the initial positions."""
    period = np.zeros(3)
    period[: len(points.period)] = points.period
    if not period.any():
        return 'pbc="F F F" '
    reference, margin = to_three_columns(points.reference), float(points.radius.max(initial=0.0))
    low = reference.min(axis=0) - margin
    sides = np.where(period > 0.0, period, reference.max(axis=0) + margin - low)
    lattice = " ".join(repr(float(one)) for one in np.diag(sides).ravel())
    origin = " ".join(repr(float(one)) for one in low)
    return f'Lattice="{lattice}" Origin="{origin}" pbc="{" ".join("T" if one else "F" for one in period > 0.0)}" '
