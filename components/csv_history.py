"""A measured history of time and value from a CSV file.

    # drop hammer, load cell 3       lines that begin with # are comments
    time [us],force [kN]             units here (or "time (us)", "time / us"), or from the caller
    0.0,0.0
    0.5,0.12

Faults name the line: an empty cell, NaN, text, a row of different length, times that do not increase, a gap in the sampling.
Nothing is filled in or sorted; only ``gaps = "bridge"`` allows a straight line across a gap.
"""

from __future__ import annotations

import csv
import math
import os
import re
import stat
from dataclasses import replace
from pathlib import Path

import numpy as np

from .errors import GranularError, ParameterError, one_line, spelling_hint
from .support.float_arrays import FloatArray
from .support.validation import finite_number, whole_number

LARGEST_FILE = 256 * 2**20
# A step longer than this number of median steps is a gap in the sampling.
_HOLE = 10.0
_CHOICES = {"delimiter": (",", ";", "\t", " "), "decimal": (".", ","), "gaps": ("refuse", "bridge")}
# Forms of a header cell with a unit: "time [us]", "time (us)", "time / us".
_HEADERS = [re.compile(rf"(?P<name>.*?)\s*{unit}") for unit in (r"\[(.*?)\]", r"\(([^()]*)\)", r"/\s*([^/]*(?:/s(?:\^2)?)?)")]

# Unit -> (SI unit, multiplier, divisor). Both numbers are exact integers, so that 3 us is exactly the float 3e-6 s.
_PREFIXES = {
    "": (1.0, 1.0), "k": (1e3, 1.0), "M": (1e6, 1.0), "G": (1e9, 1.0),
    "c": (1.0, 1e2), "m": (1.0, 1e3), "u": (1.0, 1e6), "n": (1.0, 1e9),
}  # fmt: skip
UNITS: dict[str, tuple[str, float, float]] = {
    f"{prefix}{unit}": (unit, *_PREFIXES[prefix])
    for unit, prefixes in {
        "s": ("", "m", "u", "n"), "N": ("", "k", "M", "m", "u"), "m/s": ("", "k", "c", "m", "u"), "m": ("", "c", "m", "u", "n"),
        "m/s^2": ("", "m"), "Pa": ("", "k", "M", "G"), "K": ("",), "V": ("", "k", "m", "u"),
    }.items() for prefix in prefixes
}  # fmt: skip
UNITS |= {f"{prefix}sec": ("s", *_PREFIXES[prefix]) for prefix in ("", "m", "u", "n")}
UNITS |= {"kgf": ("N", 980665.0, 1e5), "lbf": ("N", 44482216152605.0, 1e13), "g": ("m/s^2", 980665.0, 1e5)}


# Index of a column, and the factors by which its numbers are multiplied and divided.
_Column = tuple[int, float, float]


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
        path: the file, UTF-8; its header may contain the units, such as ``time [us],force [kN]``.
        time_column: a name from the header, with or without its unit, or a number from 0.
        value_column: likewise, for the values.
        time_unit: s, ms, us, ns or sec, ...; by default the unit in the header.
        value_unit: such as kN or mm/s, or V with a `scale`; by default the unit in the header.
        unit: SI unit of the values, such as N; None for the SI unit of the file's quantity.
        delimiter: column separator: a comma, a semicolon, a tab or blanks.
        decimal: the decimal mark, a point or a comma.
        skip: number of lines to skip at the beginning, such as the preamble of an oscilloscope.
        gaps: "refuse" gaps in the sampling, of over 10 median steps, or "bridge" them with a straight line.
        scale: factor of the values: a number, or `unit` per volt of a sensor.
        name: name of the file in messages; None for its path.

    Raises:
        ParameterError: names the file, the line, the text found, and the expected text.
    """
    for argument, given in {"delimiter": delimiter, "decimal": decimal, "gaps": gaps}.items():
        if given not in _CHOICES[argument]:
            expected = " or ".join(map(repr, _CHOICES[argument]))
            raise ParameterError(f"got {one_line(given)}", expected=expected, at=argument)
    for argument, given in {"time_unit": time_unit, "value_unit": value_unit, "unit": unit}.items():
        if given is not None and not isinstance(given, str):
            raise ParameterError(f"got {one_line(given)}", expected="a unit such as 'us' or 'kN'", at=argument)
    whole_number("skip", skip, 0)
    factor = 1.0 if scale is None else finite_number("scale", scale)
    try:
        lines, cells = _read_rows(Path(path), delimiter, skip)
        if not cells:
            raise ParameterError("it has no rows", hint="write a header such as 'time [us],force [kN]' and samples")
        header = None if any(_is_number(cell, decimal) for cell in cells[0]) else cells[0]
        columns = [
            _column_conversion(cells[0], header, lines[0], "time", time_column, time_unit, "s", False),
            _column_conversion(cells[0], header, lines[0], "value", value_column, value_unit, unit, scale is not None),
        ]
        if header:
            lines, cells = lines[1:], cells[1:]
        return _parse_samples(lines, cells, columns, decimal, gaps, factor)
    except TypeError:
        raise ParameterError(f"got {one_line(path)}", expected="the path of a CSV file", at="path") from None
    except ParameterError as error:
        where = str(path) if name is None else name
        raise ParameterError(*(replace(fault, received=f"{where}: {fault.received}") for fault in error.faults)) from None


def _read_rows(path: Path, delimiter: str, skip: int) -> tuple[list[int], list[list[str]]]:
    """Return the line numbers, and the cells of each line, of all lines except comments, empty and skipped lines."""
    try:
        text = read_limited_file(path, LARGEST_FILE, "reduce the number of samples").decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ParameterError(f"byte {error.start} is not UTF-8 text", hint="save the file as plain CSV") from None
    except OSError as error:
        hint = "paths in an experiment are relative to its file, paths in Python to the current folder"
        raise ParameterError(f"{path} cannot be read: {error.strerror or error}", hint=hint) from None
    lines = {number: line.strip() for number, line in enumerate(text.splitlines(), start=1) if number > skip}
    lines = {number: line for number, line in lines.items() if line and not line.startswith("#")}
    cells: list[list[str]] = []
    for number, line in lines.items():
        try:
            row = next(csv.reader([line], delimiter=delimiter, strict=True, skipinitialspace=True))
        except csv.Error as error:
            raise ParameterError(f"line {number}: {error}", hint="save the file as plain CSV") from None
        cells.append([cell.strip() for cell in row])
        expected = len(cells[0])
        if len(row) != expected or expected < 2:
            hint = "" if expected > 1 else f"the delimiter is {delimiter!r}; set delimiter, or skip lines of a preamble"
            came = f"line {number}: it has {len(row)} cells"
            raise ParameterError(came, expected=f"{expected} as in the first row" if expected > 1 else "at least 2", hint=hint)
    return list(lines), cells


def _column_conversion(
    first_row: list[str], header: list[str] | None, line: int, quantity: str, column: str | int, unit: str | None,
    wanted_unit: str | None, scaled: bool,
) -> _Column:  # fmt: skip
    """Return the index of the column of times or values, and the multiplier and divisor that convert it to the wanted unit."""
    key, place, where = f"{quantity}_column", column, f"line {line}"
    parsed = [_name_and_unit(cell) for cell in header or []]
    if isinstance(column, str):
        names = [name for name, _ in parsed] if column not in (header or []) else header or []
        if names.count(column) != 1:
            hint = spelling_hint(column, names) if header else "without a header, give the column number from 0"
            raise ParameterError(f"{where}: {key} = {column!r} is not in the header", hint=hint)
        place = names.index(column)
    elif not 0 <= column < len(first_row):
        raise ParameterError(f"{where}: {key} = {column}", expected=f"a column from 0 to {len(first_row) - 1}")
    written = parsed[int(place)][1] if header else None
    if unit is not None and written not in (None, unit) and (written in UNITS or written == wanted_unit):
        raise ParameterError(f"{where}: the unit in the header is {written!r}, but {quantity}_unit = {unit!r}", hint="omit one")
    found = unit if unit is not None else written
    if found is None:
        raise ParameterError(
            f"{where}: the {quantity}s have no unit", hint=f"set {quantity}_unit, or write the header like 'time [us]'"
        )
    base, multiply, divide = UNITS.get(found, (found if found == wanted_unit else "", 1.0, 1.0))
    if base and (base == wanted_unit or (wanted_unit is None and base != "V") or (base == "V" and scaled)):
        return int(place), multiply, divide
    expected = ", ".join(one for one, (si, _, _) in UNITS.items() if si == wanted_unit) or wanted_unit or "a unit of a quantity"
    hint = f"set {quantity}_unit; with a scale, values may be in V" if quantity == "value" else ""
    raise ParameterError(f"{where}: the {quantity}s are in {found!r}", expected=expected, hint=hint)


def _name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return the name and the unit (or None) of a header cell; "speed m/s" has no unit, as "/" is part of "m/s"."""
    for pattern in _HEADERS:
        if match := pattern.fullmatch(cell):
            name, unit = match[1].strip(), match[2].strip().replace("\u00b5", "u").replace("\u03bc", "u")
            if cell.endswith("]") or (unit in UNITS and name.rpartition(" ")[2] not in UNITS):
                return name, unit
    return cell, None


def _parse_samples(
    lines: list[int], cells: list[list[str]], columns: list[_Column], decimal: str, gaps: str, scale: float
) -> tuple[FloatArray, FloatArray]:
    if len(lines) < 2:
        raise ParameterError(f"it has {len(lines)} samples", expected="at least 2")
    found = []
    for what, factor, (place, multiply, divide) in zip(("time", "value"), (1.0, scale), columns, strict=True):
        numbers = np.empty(len(lines))
        for row, (line, texts) in enumerate(zip(lines, cells, strict=True)):
            text = texts[place]
            if not _is_number(text, decimal):
                came, expected = f"line {line}: the {what} is {text[:40]!r}", f"a finite number such as 1{decimal}5e-3"
                raise ParameterError(came, expected=expected, hint="set decimal, or skip lines of a preamble")
            numbers[row] = float(text.replace(decimal, "."))
        with np.errstate(over="ignore"):  # infinite values are refused
            numbers = numbers * multiply / divide * factor
        if not np.isfinite(numbers).all():
            raise ParameterError(f"line {lines[int(np.argmin(np.isfinite(numbers)))]}: the {what} overflows")
        found.append(numbers)
    times, values = found
    steps = np.diff(times)
    if (steps <= 0.0).any():
        late = int(np.argmax(steps <= 0.0))
        came = f"line {lines[late + 1]}: the time {times[late + 1]:g} s follows {times[late]:g} s of line {lines[late]}"
        raise ParameterError(came, hint="times must increase")
    usual = float(np.median(steps))
    holes = np.flatnonzero(steps > _HOLE * usual)
    if gaps == "refuse" and len(holes):
        at = int(holes[0])
        raise ParameterError(
            f"line {lines[at + 1]}: a gap from {times[at]:g} s to {times[at + 1]:g} s, the first of {len(holes)}; the median "
            f"step is {usual:g} s",
            hint='add the samples, or set gaps = "bridge" to interpolate linearly across gaps',
        )
    return times, values


def _is_number(text: str, decimal: str) -> bool:
    """Return whether a cell holds a finite number; the underscores that Python allows are refused."""
    try:
        return "_" not in text and math.isfinite(float(text.replace(decimal, "."))) and (decimal == "." or "." not in text)
    except ValueError:
        return False


def read_limited_file(path: Path, size_limit: int, advice: str, error_type: type[GranularError] = ParameterError) -> bytes:
    """Return the content of a regular file of at most `size_limit` bytes.

    Raises:
        GranularError: an `error_type`; the path is a folder, a device or a pipe, or the file is too large (with `advice`).
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, a pipe or a socket"
        raise error_type(f"{path}: it is {what}, expected a file")
    with path.open("rb") as file:
        data = file.read(size_limit + 1)
    if len(data) > size_limit:
        raise error_type(f"{path}: it has more than {size_limit} bytes; {advice}")
    return data
