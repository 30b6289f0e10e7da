"""Text formats: tables of histories (CSV) and particles frame by frame (extended XYZ). Numbers keep all their bits."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

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

# Rows of an XYZ file that are formatted together.
_ROWS = 10_000


def write_csv(frames: Frames, path: Path) -> None:
    """Write one row per frame: the time, then each number of each variable."""
    heads = ["time [s]"]
    for variable in map(frames.log.variables.__getitem__, frames.names):
        indices = [f"[{index_text(index)}]" if index else "" for index in np.ndindex(variable.shape)]
        heads += [with_unit(variable.name + index, variable.unit) for index in indices]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        for times, values in frames:
            columns = [one.reshape(len(times), -1) for one in (times, *values.values())]
            writer.writerows(np.hstack(columns).tolist())


def write_xyz(frames: Frames, path: Path) -> None:
    """Write a file or, for several sets of points, a folder with one file per set."""
    points = points_of(frames.log)
    paths = [path / f"{name}.xyz" for name in file_names(one.name for one in points)] if len(points) > 1 else [path]
    with ExitStack() as stack:
        files = [stack.enter_context(one.open("w", encoding="utf-8")) for one in paths]
        formats = [_frame_format(one, frames) for one in points]
        for times, values in frames:
            for place, time in enumerate(times.tolist()):
                for file, to_text in zip(files, formats, strict=True):
                    file.writelines(to_text(time, {name: one[place] for name, one in values.items()}))


def _frame_format(points: Points, frames: Frames) -> Callable[[float, dict[str, FloatArray]], Iterable[str]]:
    """Return a function that yields the text of a frame: count, comment line, rows. The symbol X means no chemical element."""
    variables, reference = frames.log.variables, to_three_columns(points.reference)
    names = [name for name in point_arrays(points, variables) if name in frames.names]
    columns = [("pos", 3, "m"), ("radius", 1, "m")]
    for name in names:
        size = prod(variables[name].shape[1:])
        columns.append((_word(name), 3 if size == 2 else size, variables[name].unit))
    properties = ":".join(["species:S:1", *(f"{name}:R:{width}" for name, width, _ in columns)])
    units = ", ".join(f"{name} {_word(unit, '/^-')}" for name, _, unit in columns)
    head = f'{_cell_text(points)} name="{_word(points.name)}" Properties={properties} units="{units}"'
    row = " ".join(["X", *["%.17g"] * sum(width for _, width, _ in columns)]) + "\n"

    def to_text(time: float, values: dict[str, FloatArray]) -> Iterable[str]:
        moved = to_three_columns(values[points.displacement]) if points.displacement in values else 0.0
        arrays = [reference + moved, points.radius[:, np.newaxis], *(vector_rows(values[name]) for name in names)]
        yield f"{len(reference)}\n{head} Time={time!r}\n"
        for begin in range(0, len(reference), _ROWS):
            part = np.hstack([one[begin : begin + _ROWS] for one in arrays])
            yield row * len(part) % tuple(part.ravel().tolist())

    return to_text


def _cell_text(points: Points) -> str:
    """Return the cell of periodic points; along other axes it encloses the initial positions."""
    period = np.zeros(3)
    period[: len(points.period)] = points.period
    flags = f'pbc="{" ".join("T" if one else "F" for one in period > 0.0)}"'
    if not period.any():
        return flags
    reference, margin = to_three_columns(points.reference), points.radius.max(initial=0.0)
    low = reference.min(axis=0) - margin
    cell = np.diag(np.where(period > 0.0, period, reference.max(axis=0) + margin - low))
    return f'Lattice="{" ".join(map(repr, cell.ravel().tolist()))}" Origin="{" ".join(map(repr, low.tolist()))}" {flags}'


def points_of(log: Log) -> list[Points]:
    """Return the points among the drawables of a log."""
    return [one for one in log.drawables if isinstance(one, Points)]


def with_unit(name: str, unit: str) -> str:
    """Return the name of a column or an array with its unit, such as "velocity [m/s]"."""
    return printable_text(f"{name} [{unit}]" if unit not in ("", "1") else name)


def file_names(names: Iterable[str]) -> list[str]:
    """Return a different file name for each name, with characters that are valid everywhere."""
    found: list[str] = []
    for name in (valid_file_name(one, "unnamed") for one in names):
        found.append(name if name not in found else f"{name}-{len(found)}")
    return found


def vector_rows(values: FloatArray) -> FloatArray:
    """Return the entries of each element as a row; vectors in a plane get a third component 0."""
    rows = values.reshape(len(values), -1)
    return to_three_columns(rows) if rows.shape[1] == 2 else rows


def _word(text: str, others: str = "") -> str:
    """Return a text without characters that have a meaning in the format."""
    return re.sub(rf"[^\w{others}]+", "_", text) or "_"
