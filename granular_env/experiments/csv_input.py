"""A measured history, time and value, from a CSV file.

    # drop hammer, load cell 3       lines that begin with # are comments
    time [us],force [kN]             units here, or in the experiment file, or in both where they agree
    0.0,0.0
    0.5,0.12

Every fault is named by its line: a gap, a hole in the sampling, NaN, text, a row that is too short or too long, times that do
not increase. Nothing is filled in or sorted: what was measured is what runs. Only where the experiment says
``gaps = "bridge"`` a straight line leads across a hole.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ExperimentError, nearest

from .files import read_bounded

FloatArray = npt.NDArray[np.float64]
Row = tuple[int, list[str]]
Header = list[tuple[str, str | None]]

LARGEST_FILE = 256 * 2**20
_DELIMITERS = (",", ";", "\t")
# A step so many times the median one is a hole in the sampling.
_HOLE = 10.0
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_HEADER = re.compile(r"(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")

# Unit -> (SI unit, multiply by, divide by). Both are whole numbers that floats hold exactly, so that 3 us is 3e-6 s to the bit.
UNITS: dict[str, tuple[str, float, float]] = {
    "s": ("s", 1.0, 1.0), "ms": ("s", 1.0, 1e3), "us": ("s", 1.0, 1e6), "ns": ("s", 1.0, 1e9),
    "N": ("N", 1.0, 1.0), "kN": ("N", 1e3, 1.0), "MN": ("N", 1e6, 1.0), "mN": ("N", 1.0, 1e3), "uN": ("N", 1.0, 1e6),
    "m/s": ("m/s", 1.0, 1.0), "km/s": ("m/s", 1e3, 1.0), "cm/s": ("m/s", 1.0, 1e2), "mm/s": ("m/s", 1.0, 1e3),
    "um/s": ("m/s", 1.0, 1e6),
    "m": ("m", 1.0, 1.0), "cm": ("m", 1.0, 1e2), "mm": ("m", 1.0, 1e3), "um": ("m", 1.0, 1e6), "nm": ("m", 1.0, 1e9),
    "m/s^2": ("m/s^2", 1.0, 1.0), "mm/s^2": ("m/s^2", 1.0, 1e3),
    "Pa": ("Pa", 1.0, 1.0), "kPa": ("Pa", 1e3, 1.0), "MPa": ("Pa", 1e6, 1.0), "GPa": ("Pa", 1e9, 1.0),
    "K": ("K", 1.0, 1.0),
}  # fmt: skip


def read_history(
    path: Path,
    time_column: str | int,
    value_column: str | int,
    time_unit: str | None,
    value_unit: str | None,
    unit: str,
    delimiter: str = ",",
    bridge: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Times [s], increasing, and values [`unit`], both of shape (rows,).

    Args:
        path: the file, UTF-8.
        time_column: a name from the header, or a number from 0.
        value_column: likewise.
        time_unit: s, ms, us or ns; None where the header says it.
        value_unit: any of `UNITS` that measures the same quantity as `unit`; None where the header says it.
        unit: SI unit that is wanted.
        delimiter: what separates the columns.
        bridge: accept holes in the sampling; a straight line leads across each.

    Raises:
        ExperimentError: the file and the line, what stands there, and what was expected.
    """
    rows = list(_rows(path, delimiter))
    if not rows:
        raise ExperimentError(f"{path}: it holds no rows; expected a header such as 'time [us],force [kN]' and samples")
    _check_delimiter(path, *rows[0], delimiter)
    header = _header(rows[0][1])
    first, second = (
        _column(path, rows[0], header, key, column)
        for key, column in (("time_column", time_column), ("value_column", value_column))
    )
    if first == second:
        raise ExperimentError(f"{path}: time_column and value_column both name column {first}; give two different ones")
    written = [header[place][1] if header else None for place in (first, second)]
    line = rows[0][0]
    to_seconds = _conversion(path, line, "time_unit", time_unit, written[0], "s")
    to_value = _conversion(path, line, "value_unit", value_unit, written[1], unit)
    samples = rows[1:] if header else rows
    if len(samples) < 2:
        raise ExperimentError(f"{path}: it holds {len(samples)} samples, expected at least 2")
    times, values = _numbers(path, samples, len(rows[0][1]), first, second)
    with np.errstate(over="ignore"):  # told of below, with the line
        times, values = times * to_seconds[0] / to_seconds[1], values * to_value[0] / to_value[1]
    _check_order(path, samples, times)
    if not bridge:
        _refuse_holes(path, samples, times)
    if not np.isfinite(values).all():
        where = int(np.argmin(np.isfinite(values)))
        raise ExperimentError(f"{path}: line {samples[where][0]}: the value overflows in {unit}")
    return times, values


def _refuse_holes(path: Path, samples: Sequence[Row], times: FloatArray) -> None:
    """A step far above the median one is a hole in the measurement: a straight line across it would be made up."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    holes = np.flatnonzero(steps > _HOLE * usual)
    if len(holes):
        before = int(holes[0])
        more = f"; it is the first of {len(holes)} holes" if len(holes) > 1 else ""
        raise ExperimentError(
            f"{path}: line {samples[before + 1][0]}: a hole from {times[before]:g} s (line {samples[before][0]}) to "
            f'{times[before + 1]:g} s, where the median step is {usual:g} s{more}; fill it in, or set gaps = "bridge" in the '
            "input's table to go across in a straight line"
        )


def _check_delimiter(path: Path, line: int, cells: list[str], delimiter: str) -> None:
    if len(cells) > 1:
        return
    other = next((mark for mark in _DELIMITERS if mark != delimiter and mark in cells[0]), None)
    advice = "the columns are to be separated by commas, semicolons or tabs" if other is None else _set_delimiter(other)
    raise ExperimentError(f"{path}: line {line}: there is one column only, with delimiter = {json.dumps(delimiter)}; {advice}")


def _set_delimiter(mark: str) -> str:
    return f"set delimiter = {json.dumps(mark)} in the input's table"


def _rows(path: Path, delimiter: str) -> Iterator[Row]:
    """Line number and cells of every row that is no comment; empty lines may stand before and after the samples only."""
    gap, begun = 0, False
    for number, line in enumerate(_text(path).split("\n"), start=1):
        text = line.strip()
        if text.startswith("#"):
            continue
        if not text:
            gap = number
            continue
        try:
            cells = [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter, strict=True, skipinitialspace=True))]
        except csv.Error:
            long = len(text) > csv.field_size_limit()
            fault = "a cell is too long" if long else "a quotation mark is not closed, or does not enclose a whole cell"
            raise ExperimentError(f"{path}: line {number}: {fault}") from None
        if gap and begun:
            raise ExperimentError(f"{path}: line {gap}: it is empty, between samples; a gap is not filled in")
        gap, begun = 0, begun or bool(_NUMBER.fullmatch(cells[0]))
        yield number, cells


def _text(path: Path) -> str:
    try:
        data = read_bounded(path, LARGEST_FILE, "thin the samples out")
    except ExperimentError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ExperimentError(
            f"{path}: the CSV file cannot be read: {reason}; paths are relative to the experiment file"
        ) from None
    # Some programs end lines by a carriage return alone.
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise ExperimentError(f"{path}: line {line}: it is not UTF-8 text; save the file as plain CSV") from None


def _header(cells: list[str]) -> Header | None:
    """(name, unit or None) for each column; None where the first row already holds numbers."""
    if any(_NUMBER.fullmatch(cell) for cell in cells):
        return None
    header: Header = []
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        header.append((cell, None) if match is None else (match["name"].strip(), match["unit"]))
    return header


def _column(path: Path, row: Row, header: Header | None, key: str, column: str | int) -> int:
    line, cells = row
    if isinstance(column, int):
        if not 0 <= column < len(cells):
            raise ExperimentError(f"{path}: line {line}: {key} = {column}, and there are columns 0 to {len(cells) - 1}")
        return column
    if header is None:
        raise ExperimentError(
            f"{path}: line {line}: {key} = {column!r}, and the file has no header line; "
            f"give the column's number from 0, or write a header such as 'time [us],force [kN]'"
        )
    names = [name for name, _ in header]
    if names.count(column) != 1:
        advice = "it stands there more than once" if column in names else nearest(column, names)
        raise ExperimentError(f"{path}: line {line}: {key} = {column!r} is no column of the header; {advice}")
    return names.index(column)


def _conversion(path: Path, line: int, key: str, declared: str | None, written: str | None, wanted: str) -> tuple[float, float]:
    """(multiply by, divide by) to get to the SI unit that is wanted."""
    spoken = [unit.strip().replace("\u00b5", "u").replace("\u03bc", "u") for unit in (declared, written) if unit is not None]
    if not spoken:
        raise ExperimentError(
            f"{path}: line {line}: no unit; set {key} in the experiment file, or write the header like 'time [us],force [kN]'"
        )
    if len(set(spoken)) > 1:
        raise ExperimentError(
            f"{path}: line {line}: the header says {spoken[1]!r}, the experiment file has {key} = {spoken[0]!r}"
        )
    fitting = [name for name, (base, _, _) in UNITS.items() if base == wanted]
    unit = UNITS.get(spoken[0], ("", 1.0, 1.0) if spoken[0] != wanted else (wanted, 1.0, 1.0))
    if unit[0] != wanted:
        came = f"{spoken[0]!r} measures something else" if unit[0] else f"{spoken[0]!r} is unknown"
        raise ExperimentError(f"{path}: line {line}: {key}: {came}, expected {', '.join(fitting) or wanted}")
    return unit[1], unit[2]


def _numbers(path: Path, samples: list[Row], width: int, first: int, second: int) -> tuple[FloatArray, FloatArray]:
    times, values = np.empty(len(samples)), np.empty(len(samples))
    for place, (line, cells) in enumerate(samples):
        if len(cells) != width:
            raise ExperimentError(f"{path}: line {line}: it has {len(cells)} cells, expected {width} as in the first row")
        times[place] = _number(path, line, "time", cells[first])
        values[place] = _number(path, line, "value", cells[second])
    return times, values


def _number(path: Path, line: int, what: str, cell: str) -> float:
    if not cell:
        raise ExperimentError(f"{path}: line {line}: the {what} is empty; a gap is not filled in")
    if _NUMBER.fullmatch(cell):
        number = float(cell)
        if math.isfinite(number):
            return number
    mark = next((mark for mark in _DELIMITERS if mark in cell), None)
    advice = "" if mark is None else "; write decimal points" if mark == "," else f"; {_set_delimiter(mark)}"
    raise ExperimentError(f"{path}: line {line}: the {what} is {cell[:40]!r}, expected a finite number such as 1.5e-3{advice}")


def _check_order(path: Path, samples: list[Row], times: FloatArray) -> None:
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        place = int(late[0]) + 1
        how = "repeats" if times[place] == times[place - 1] else "goes back behind"
        raise ExperimentError(
            f"{path}: line {samples[place][0]}: the time {times[place]:g} s {how} that of line {samples[place - 1][0]} "
            f"({times[place - 1]:g} s); times must increase"
        )
