"""Text formats: tables of histories (CSV) and particles frame by frame (extended XYZ). Numbers keep all their bits."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...components.drawables import Points, to_three_columns
from ...components.support.float_arrays import FloatArray
from ...components.variables import Element
from ...terminal_text import printable_text
from ..element_arrays import element_arrays
from ..preview.visible_drawables import is_hidden
from .frames import Frames

if TYPE_CHECKING:
    from ..log import Log


def write_csv(frames: Frames, path: Path) -> None:
    """Write one row per frame: the time, then each number of each variable."""
    heads = ["time [s]"]
    for variable in map(frames.log.variables.__getitem__, frames.names):
        heads += [with_unit(str(Element(variable.name, index)), variable.unit) for index in np.ndindex(variable.shape)]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        writer.writerows(np.concatenate([[time], *map(np.ravel, frame.values())]).tolist() for time, frame in frames)


def write_xyz(frames: Frames, path: Path) -> None:
    """Write the positions and radii of the particles, and their arrays."""
    points, variables = particles(frames.log)[0], frames.log.variables
    names = [name for name in element_arrays(points, variables)[0] if name in frames.names]
    with path.open("w", encoding="utf-8") as file:
        for time, frame in frames:
            positions = to_three_columns(points.reference)
            if points.displacement in frame:
                positions = positions + to_three_columns(frame[points.displacement])
            columns = [("pos", "m", positions), ("radius", "m", vector_rows(points.radius))]
            columns += [(_word(name), variables[name].unit, vector_rows(frame[name])) for name in names]
            rows = np.hstack([values for *_, values in columns])
            head = f"{len(rows)}\n{_comment(points, columns)} Time={time!r}"
            np.savetxt(file, rows, "X" + rows.shape[1] * " %.17g", header=head, comments="")


def _comment(points: Points, columns: list[tuple[str, str, FloatArray]]) -> str:
    """Return the comment line of a frame without its time; columns are name, unit and values."""
    period = np.zeros(3)
    period[: len(points.period)] = points.period
    texts = [f'pbc="{" ".join("FT"[int(flag)] for flag in period > 0.0)}"', f'name="{_word(points.name)}"']
    if period.any():  # along other axes the cell encloses the initial positions
        reference, margin = to_three_columns(points.reference), points.radius.max(initial=0.0)
        low = reference.min(axis=0) - margin
        cell = np.diag(np.where(period > 0.0, period, reference.max(axis=0) + margin - low))
        texts += [f'{key}="{" ".join(map(repr, one.ravel().tolist()))}"' for key, one in (("Lattice", cell), ("Origin", low))]
    properties = [f"{name}:R:{values.shape[1]}" for name, _, values in columns]
    units = ", ".join(f"{name} {_word(unit, '/^-')}" for name, unit, _ in columns)
    return f'{" ".join(texts)} Properties=species:S:1:{":".join(properties)} units="{units}"'


def particles(log: Log) -> list[Points]:
    """Return the points that an XYZ file contains, a list of at most one: those that viewers show rather than nodes."""
    points = [one for one in log.drawables if isinstance(one, Points)]
    return sorted(points, key=lambda one: is_hidden(one, log.drawables))[:1]


def with_unit(name: str, unit: str) -> str:
    """Return the name of a column or an array with its unit, such as "velocity [m/s]"."""
    return printable_text(f"{name} [{unit}]" if unit not in ("", "1") else name)


def vector_rows(values: FloatArray) -> FloatArray:
    """Return the entries of each element as a row; vectors in a plane get a third component 0."""
    rows = values.reshape(len(values), -1)
    return to_three_columns(rows) if rows.shape[1] == 2 else rows


def _word(text: str, others: str = "") -> str:
    """Return a text without characters that have a meaning in the format."""
    return re.sub(rf"[^\w{others}]+", "_", text) or "_"
