"""A measured history, time and value, from a CSV file.

    # drop hammer, load cell 3       lines that begin with # are comments
    time [us],force [kN]             units here (or "time (us)", "time / us"), or from the caller, or both where they agree
    0.0,0.0
    0.5,0.12

Every fault is named by its line: a gap, a hole in the sampling, NaN, text, a row that is too short or too long, times that do
not increase. Nothing is filled in or sorted: what was measured is what runs. Only with ``gaps = "bridge"`` a straight line
leads across a hole.
"""

from __future__ import annotations

import codecs
import csv
import json
import math
import os
import re
import stat
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from .errors import GranularError, ParameterError, nearest, one_line
from .support.float_arrays import FloatArray

Row = tuple[int, list[str]]
Header = list[tuple[str, str | None]]

LARGEST_FILE = 256 * 2**20
_DELIMITERS = (",", ";", "\t", " ")
# A step so many times the median one is a hole in the sampling.
_HOLE = 10.0
_DECIMALS = {mark: re.compile(rf"[+-]?(\d+{re.escape(mark)}?\d*|{re.escape(mark)}\d+)([eE][+-]?\d+)?") for mark in ".,"}
_BRACKETS = re.compile(r"(?P<name>[^\[\]]*?)\s*\[(?P<unit>[^\[\]]*)\]")
_PARENTHESES = re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*)\)")
_SLASH = re.compile(r"(?P<name>[^/]*?)\s*/\s*(?P<unit>.*)")

# Unit -> (SI unit, multiply by, divide by). Both are whole numbers that floats hold exactly, so that 3 us is 3e-6 s to the bit.
UNITS: dict[str, tuple[str, float, float]] = {
    "s": ("s", 1.0, 1.0), "ms": ("s", 1.0, 1e3), "us": ("s", 1.0, 1e6), "ns": ("s", 1.0, 1e9),
    "sec": ("s", 1.0, 1.0), "msec": ("s", 1.0, 1e3), "usec": ("s", 1.0, 1e6), "nsec": ("s", 1.0, 1e9),
    "N": ("N", 1.0, 1.0), "kN": ("N", 1e3, 1.0), "MN": ("N", 1e6, 1.0), "mN": ("N", 1.0, 1e3), "uN": ("N", 1.0, 1e6),
    "kgf": ("N", 980665.0, 1e5), "lbf": ("N", 44482216152605.0, 1e13),
    "m/s": ("m/s", 1.0, 1.0), "km/s": ("m/s", 1e3, 1.0), "cm/s": ("m/s", 1.0, 1e2), "mm/s": ("m/s", 1.0, 1e3),
    "um/s": ("m/s", 1.0, 1e6),
    "m": ("m", 1.0, 1.0), "cm": ("m", 1.0, 1e2), "mm": ("m", 1.0, 1e3), "um": ("m", 1.0, 1e6), "nm": ("m", 1.0, 1e9),
    "m/s^2": ("m/s^2", 1.0, 1.0), "mm/s^2": ("m/s^2", 1.0, 1e3), "g": ("m/s^2", 980665.0, 1e5),
    "Pa": ("Pa", 1.0, 1.0), "kPa": ("Pa", 1e3, 1.0), "MPa": ("Pa", 1e6, 1.0), "GPa": ("Pa", 1e9, 1.0),
    "K": ("K", 1.0, 1.0),
    "V": ("V", 1.0, 1.0), "kV": ("V", 1e3, 1.0), "mV": ("V", 1.0, 1e3), "uV": ("V", 1.0, 1e6),
}  # fmt: skip
# What a sensor gives; a scale turns it into the quantity that is wanted.
_SIGNAL = "V"


def read_history(
    path: str | os.PathLike[str],
    *,
    time_column: str | int = 0,
    value_column: str | int = 1,
    time_unit: str | None = None,
    value_unit: str | None = None,
    unit: str | None = None,
    delimiter: str = ",",
    decimal: str = ".",
    skip: int = 0,
    gaps: str = "refuse",
    scale: float | None = None,
    name: str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the times [s], increasing, and the values [`unit`], both of shape (rows,).

    Args:
        path: the file, UTF-8, or UTF-16 with a byte order mark; comments and the header may be Latin-1.
        time_column: a name from the header, with or without its unit, or a number from 0.
        value_column: likewise.
        time_unit: s, ms, us, ns or sec, ...; None where the header says it.
        value_unit: any of `UNITS` that measures the same quantity as `unit`, or V, mV, ... with a `scale`; None where the
            header says it. It replaces a unit of the header that is not in `UNITS`.
        unit: SI unit that is wanted; None for that of the file's quantity.
        delimiter: what separates the columns: a comma, a semicolon, a tab or blanks.
        decimal: the decimal mark, a point or a comma.
        skip: how many lines at the beginning are left out, such as the preamble of an oscilloscope.
        gaps: "bridge" to accept holes in the sampling; a straight line leads across each.
        scale: the values are multiplied by it: a number, or `unit` for each volt.
        name: what the file is called in messages; None for its path.

    Raises:
        ParameterError: the file and the line, what stands there, and what was expected.
    """
    opened = _as_path(path)
    path = opened if name is None else Path(name)
    _check_choices(delimiter=(delimiter, _DELIMITERS), decimal=(decimal, (".", ",")), gaps=(gaps, ("refuse", "bridge")))
    for argument, given in (("time_unit", time_unit), ("value_unit", value_unit), ("unit", unit)):
        if given is not None and not isinstance(given, str):
            raise ParameterError(f"got {one_line(given)}", expected="a unit such as 'us' or 'kN'", at=argument)
    if isinstance(skip, bool) or not isinstance(skip, int) or skip < 0:
        raise ParameterError(
            f"got {one_line(skip)}", expected="how many lines to leave out, a whole number from 0 on", at="skip"
        )
    rows = list(_rows(path, _content(opened), delimiter, decimal, skip))
    if not rows:
        raise ParameterError(
            "it holds no rows", hint="expected a header such as 'time [us],force [kN]' and samples", source=str(path)
        )
    try:
        samples, width, places, conversions = _understand_header(
            path, rows, (time_column, value_column), (time_unit, value_unit), unit, delimiter, decimal, scale is not None
        )
        times, values = _numbers(path, samples, width, places, decimal)
    except ParameterError as error:
        advice = _preamble_advice(rows, decimal, skip)
        raise (error.with_hint(advice) if advice else error) from None
    to_seconds, to_value = conversions
    with np.errstate(over="ignore"):  # told of below, with the line
        times, values = times * to_seconds[0] / to_seconds[1], values * to_value[0] / to_value[1]
        values = values * scale if scale is not None and scale != 1.0 else values
    _check_order(path, samples, times)
    if gaps == "refuse":
        _refuse_holes(path, samples, times)
    if not np.isfinite(values).all():
        where = int(np.argmin(np.isfinite(values)))
        raise ParameterError(
            f"line {samples[where][0]}: the value overflows{f' in {unit}' if unit else ''}",
            hint="look at its unit and at scale",
            source=str(path),
        )
    return times, values


def _as_path(path: str | os.PathLike[str]) -> Path:
    try:
        return Path(path)
    except TypeError:
        raise ParameterError(f"got {one_line(path)}", expected="the path of a CSV file", at="path") from None


def _check_choices(**choices: tuple[str, Sequence[str]]) -> None:
    for name, (chosen, known) in choices.items():
        if chosen not in known:
            raise ParameterError(f"got {one_line(chosen)}", expected=" or ".join(map(json.dumps, known)), at=name)


def _understand_header(
    path: Path,
    rows: list[Row],
    columns: tuple[str | int, str | int],
    units: tuple[str | None, str | None],
    unit: str | None,
    delimiter: str,
    decimal: str,
    scaled: bool,
) -> tuple[list[Row], int, tuple[int, int], list[tuple[float, float]]]:
    """Return the samples, the number of columns, the places of time and value among them, and the conversions of both."""
    _check_delimiter(path, *rows[0], delimiter)
    header = _header(rows[0][1], decimal)
    first, second = (
        _column(path, rows[0], header, key, column)
        for key, column in zip(("time_column", "value_column"), columns, strict=True)
    )
    if first == second:
        raise ParameterError(
            f"time_column and value_column both name column {first}", hint="give two different ones", source=str(path)
        )
    line, written = rows[0][0], [header[place][1] if header else None for place in (first, second)]
    conversions = [
        _conversion(path, line, "time_unit", units[0], written[0], "s", False),
        _conversion(path, line, "value_unit", units[1], written[1], unit, scaled),
    ]
    samples = rows[1:] if header else rows
    if len(samples) < 2:
        raise ParameterError(f"it holds {len(samples)} samples", expected="at least 2", source=str(path))
    return samples, len(rows[0][1]), (first, second), conversions


def _preamble_advice(rows: list[Row], decimal: str, skip: int) -> str:
    """Return what to do where lines of text stand before the samples: oscilloscopes write such."""
    place = _first_sample(rows, decimal)
    if skip or not place:
        return ""
    (above, header), (line, cells) = rows[place - 1], rows[place]
    if len(header) == len(cells):
        # Either the header, or a sample that is damaged.
        if place == 1 or _header(header, decimal) is None:
            return ""
        return f"numbers begin in line {line}: if lines stand before the header, set skip = {above - 1}"
    return f"samples begin in line {line}, without a header: if what stands before is a preamble, set skip = {line - 1}"


def _first_sample(rows: list[Row], decimal: str) -> int:
    """Return where the longest run of rows of numbers begins, 0 without one: a preamble may hold numbers too."""

    def width(row: Row) -> int:
        numbers = len(row[1]) > 1 and all(map(_DECIMALS[decimal].fullmatch, filter(None, row[1])))
        return len(row[1]) if numbers else 0

    place = first = longest = 0
    for cells, run in groupby(rows, width):
        length = sum(1 for _ in run)
        if cells and length > longest:
            first, longest = place, length
        place += length
    return first


def _refuse_holes(path: Path, samples: Sequence[Row], times: FloatArray) -> None:
    """Raise an error for a step far above the median: a straight line across such a hole would be made up."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    holes = np.flatnonzero(steps > _HOLE * usual)
    if len(holes):
        before = int(holes[0])
        more = f"; it is the first of {len(holes)} holes" if len(holes) > 1 else ""
        raise ParameterError(
            f"line {samples[before + 1][0]}: a hole from {times[before]:g} s (line {samples[before][0]}) to "
            f"{times[before + 1]:g} s, where the median step is {usual:g} s{more}",
            hint='fill it in, or set gaps = "bridge" to go across in a straight line',
            source=str(path),
        )


def _check_delimiter(path: Path, line: int, cells: list[str], delimiter: str) -> None:
    if len(cells) > 1:
        return
    other = next((mark for mark in _DELIMITERS if mark != delimiter and mark in cells[0]), None)
    advice = "the columns are to be separated by commas, semicolons, tabs or blanks" if other is None else _set_delimiter(other)
    raise ParameterError(
        f"line {line}: there is one column only, with delimiter = {json.dumps(delimiter)}", hint=advice, source=str(path)
    )


def _set_delimiter(mark: str) -> str:
    return f"set delimiter = {json.dumps(mark)}"


def _rows(path: Path, content: bytes, delimiter: str, decimal: str, skip: int) -> Iterator[Row]:
    """Line number and cells of every row that is no comment; empty lines may stand before and after the samples only."""
    gap, begun = 0, False
    for number, line in enumerate(content.split(b"\n"), start=1):
        if number <= skip:
            continue
        text = _decode(path, number, line, begun).strip()
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
            raise ParameterError(f"line {number}: {fault}", hint="save the file as plain CSV", source=str(path)) from None
        if gap and begun:
            raise ParameterError(f"line {gap}: it is empty, between samples", hint="a gap is not filled in", source=str(path))
        gap, begun = 0, begun or bool(_DECIMALS[decimal].fullmatch(cells[0]))
        yield number, cells


def _decode(path: Path, number: int, line: bytes, begun: bool) -> str:
    """Return a line as text: UTF-8, or Latin-1 (a micro sign, names) in a comment or before the first sample."""
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        if b"\0" not in line and (not begun or line.lstrip().startswith(b"#")):
            return line.decode("latin-1")
        raise ParameterError(
            f"line {number}: it is not UTF-8 text", hint="save the file as plain CSV", source=str(path)
        ) from None


def _content(path: Path) -> bytes:
    try:
        data = read_bounded(path, LARGEST_FILE, "thin the samples out")
    except ParameterError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ParameterError(
            f"the CSV file cannot be read: {reason}",
            hint="paths are relative to the experiment file, from Python to the current folder",
            source=str(path),
        ) from None
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode()
    # Some programs end lines by a carriage return alone.
    return data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _header(cells: list[str], decimal: str) -> Header | None:
    """(name, unit or None) for each column; None where the first row already holds numbers."""
    if any(_DECIMALS[decimal].fullmatch(cell) for cell in cells):
        return None
    header: Header = []
    for cell in cells:
        match = _BRACKETS.fullmatch(cell) or _known_unit(_PARENTHESES.fullmatch(cell)) or _known_unit(_SLASH.fullmatch(cell))
        header.append((cell, None) if match is None else (match["name"].strip(), match["unit"]))
    return header


def _known_unit(match: re.Match[str] | None) -> re.Match[str] | None:
    """Return a name with a unit that is known; None for others, and for "speed m/s", which is not a name over a second."""
    if match is None or _plain_unit(match["unit"]) not in UNITS or match["name"].rpartition(" ")[2] in UNITS:
        return None
    return match


def _plain_unit(unit: str) -> str:
    return unit.strip().replace("\u00b5", "u").replace("\u03bc", "u")


def _column(path: Path, row: Row, header: Header | None, key: str, column: str | int) -> int:
    line, cells = row
    if isinstance(column, int):
        if not 0 <= column < len(cells):
            raise ParameterError(
                f"line {line}: {key} = {column}", expected=f"a column from 0 to {len(cells) - 1}", source=str(path)
            )
        return column
    if header is None:
        raise ParameterError(
            f"line {line}: {key} = {column!r}, and the file has no header line",
            hint="give the column's number from 0, or write a header such as 'time [us],force [kN]'",
            source=str(path),
        )
    names = [name for name, _ in header]
    if column not in names and column in cells:
        names = cells
    if names.count(column) != 1:
        advice = "it stands there more than once" if column in names else nearest(column, names)
        raise ParameterError(f"line {line}: {key} = {column!r} is no column of the header", hint=advice, source=str(path))
    return names.index(column)


def _conversion(
    path: Path, line: int, key: str, declared: str | None, written: str | None, wanted: str | None, scaled: bool
) -> tuple[float, float]:
    """(multiply by, divide by) to get to the SI unit that is wanted, or to volts where these are scaled."""
    if declared is not None and written is not None and _plain_unit(written) not in (*UNITS, wanted):
        written = None
    spoken = [_plain_unit(unit) for unit in (declared, written) if unit is not None]
    if not spoken:
        raise ParameterError(
            f"line {line}: no unit", hint=f"set {key}, or write the header like 'time [us],force [kN]'", source=str(path)
        )
    if len(set(spoken)) > 1:
        raise ParameterError(
            f"line {line}: the header says {spoken[1]!r}, and {key} = {spoken[0]!r} was given",
            hint=f"leave {key} out, or give it as the header does",
            source=str(path),
        )
    base, multiply, divide = UNITS.get(spoken[0], (spoken[0] if spoken[0] == wanted else "", 1.0, 1.0))
    if base == wanted or (base and wanted is None and base != _SIGNAL) or (base == _SIGNAL and scaled):
        return multiply, divide
    fitting = [name for name, (of, _, _) in UNITS.items() if of == wanted or (wanted is None and of != _SIGNAL)]
    if base == _SIGNAL and key == "value_unit":
        scale = f"set scale, in {wanted or 'the SI unit of the quantity'} for each volt"
        raise ParameterError(
            f"line {line}: {key}: {spoken[0]!r} is a sensor's signal",
            hint=f"{scale}, or give {', '.join(fitting) or wanted}",
            source=str(path),
        )
    came = f"{spoken[0]!r} measures something else" if base else f"{spoken[0]!r} is unknown"
    advice = "" if base or key == "time_unit" else "set value_unit, and scale for the conversion"
    raise ParameterError(
        f"line {line}: {key}: {came}", expected=", ".join(fitting) or wanted or "", hint=advice, source=str(path)
    )


def _numbers(
    path: Path, samples: list[Row], width: int, places: tuple[int, int], decimal: str
) -> tuple[FloatArray, FloatArray]:
    times, values = np.empty(len(samples)), np.empty(len(samples))
    for place, (line, cells) in enumerate(samples):
        if len(cells) != width:
            raise ParameterError(
                f"line {line}: it has {len(cells)} cells", expected=f"{width} as in the first row", source=str(path)
            )
        times[place] = _number(path, line, "time", cells[places[0]], decimal)
        values[place] = _number(path, line, "value", cells[places[1]], decimal)
    return times, values


def _number(path: Path, line: int, what: str, cell: str, decimal: str) -> float:
    if not cell:
        raise ParameterError(f"line {line}: the {what} is empty", hint="a gap is not filled in", source=str(path))
    if _DECIMALS[decimal].fullmatch(cell):
        number = float(cell.replace(decimal, "."))
        if math.isfinite(number):
            return number
    raise ParameterError(
        f"line {line}: the {what} is {cell[:40]!r}",
        expected=f"a finite number such as 1{decimal}5e-3",
        hint=_mark_advice(cell, decimal),
        source=str(path),
    )


def _mark_advice(cell: str, decimal: str) -> str:
    other = "," if decimal == "." else "."
    if _DECIMALS[other].fullmatch(cell):
        points = "write decimal points, or " if other == "," else ""
        return f"{points}set decimal = {json.dumps(other)}"
    mark = next((mark for mark in _DELIMITERS if mark in cell), None)
    return "" if mark is None else "write decimal points" if mark == "," else _set_delimiter(mark)


def _check_order(path: Path, samples: list[Row], times: FloatArray) -> None:
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        place = int(late[0]) + 1
        how = "repeats" if times[place] == times[place - 1] else "goes back behind"
        raise ParameterError(
            f"line {samples[place][0]}: the time {times[place]:g} s {how} that of line {samples[place - 1][0]} ("
            f"{times[place - 1]:g} s)",
            hint="times must increase",
            source=str(path),
        )


def read_bounded(path: Path, largest: int, advice: str, kind: type[GranularError] = ParameterError) -> bytes:
    """Return the content of a regular file of at most `largest` bytes.

    Raises:
        GranularError: of that `kind`; it is a folder, a device or a pipe, or too large; `advice` says what to do then.
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, a pipe or a socket"
        raise kind(f"{path}: it is {what}, expected a file")
    with path.open("rb") as file:
        data = file.read(largest + 1)
    if len(data) > largest:
        raise kind(f"{path}: it has more than {largest} bytes; {advice}")
    return data
