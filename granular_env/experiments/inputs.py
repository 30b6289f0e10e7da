"""Inputs of an experiment file: a number, a list or {index: value or row} for an input of several elements, or a profile.

    [input.left_force]
    profile = "triangle"      # constant, triangle, half_sine, table, csv, piecewise, sum
    peak = 2000.0
    duration = 1e-4
    pattern = [1.0, 0.5]      # for an input of several elements: factor of each element

Times are in seconds, values in the input's SI unit, or both are texts with a unit, such as "0.1 ms" and "2 kN".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, TypeAdapter, field_validator

from granular_env.components.errors import ParameterError, one_line
from granular_env.components.number_arrays import number_array
from granular_env.components.profiles import Profile
from granular_env.components.support.quantities import Quantity, Seconds, Value, to_si
from granular_env.components.variables import is_index
from granular_env.documents import Table, TableChoice


def csv_tables(content: Any) -> Iterator[dict[str, Any]]:
    """Yield each profile table that names a CSV file in an experiment's content, also if it is a term of a sum of profiles."""
    if isinstance(content, dict) and content.get("profile") == "csv":
        yield content
    elif isinstance(content, dict | list):
        for part in content.values() if isinstance(content, dict) else content:
            yield from csv_tables(part)


def _parse_array(value: Any) -> list[Any]:
    """Return `value` unchanged if it is a list of numbers or of equally long rows; raise a fault for anything else."""
    expected = "numbers, in a list or in rows of equal length"
    array = number_array((), value, expected)
    if not isinstance(value, list) or not array.size:
        raise ParameterError(f"got {one_line(value)}", expected=expected)
    return value


def _parse_elements(content: Any) -> dict[str, Any] | None:
    """Return a mapping {index: value or row of values} with the indices as text; None if `content` is not such a mapping."""
    if isinstance(content, Mapping) and content and all(map(is_index, content)):
        return {str(key): value for key, value in content.items()}
    return None


def _parse_pattern(value: Any) -> list[Any] | dict[str, Any]:
    return _parse_elements(value) or _parse_array(value)


class ProfileTable(Table):
    """A profile: the input as a function of time. The other keys depend on `profile`."""

    profile: Any = Field(description="kind of time profile: constant, triangle, half_sine, table, csv, piecewise or sum")
    pattern: Annotated[list[Any] | dict[str, Any], PlainValidator(_parse_pattern)] | None = Field(
        None,
        description="factor of each element of the input: a list, or a table {index: value or row}; default: 1",
    )

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return the hint for an index used as a key of a profile table: how to set one element of an input with a profile."""
        return f"set an element of a profile in its pattern: pattern[{key}]" if is_index(key) else ""

    def make_profile(self, folder: Path, unit: str) -> Profile:
        """Return the profile object for an input with this unit; a CSV file's path is relative to `folder`."""
        return getattr(Profile, self.profile)(**self.arguments(unit))

    def arguments(self, unit: str) -> dict[str, Any]:
        """Return the keys that a constructor of `Profile` takes, after checking the units of the values."""
        keys = self.model_dump(exclude={"profile", "pattern"})
        return {key: value if isinstance(value, str) else to_si(value, unit, (key,)) for key, value in keys.items()}


class ConstantTable(ProfileTable):
    """An input that is 0 until the time `start` and has the constant `value` afterwards."""

    profile: Literal["constant"] = "constant"
    value: Value = Field(description="value of the input, in the input's unit")
    start: Seconds = Field(0.0, description="start time [s]")


class TriangleTable(ProfileTable):
    """A triangle: from 0 to `peak` in the time `rise`, back to 0 at the time `duration`; with rise = 0 it starts at `peak`."""

    profile: Literal["triangle"] = "triangle"
    peak: Value = Field(description="peak value, in the input's unit")
    duration: Seconds = Field(description="length of the pulse [s]")
    rise: Seconds = Field(0.0, description="time from 0 to the peak [s]")
    start: Seconds = Field(0.0, description="start time [s]")


class HalfSineTable(ProfileTable):
    """A pulse of the form of the first half of a sine wave; `duration` is its length."""

    profile: Literal["half_sine"] = "half_sine"
    peak: Value = Field(description="peak value, in the input's unit")
    duration: Seconds = Field(description="length of the pulse [s]")
    start: Seconds = Field(0.0, description="start time [s]")


class SamplesTable(ProfileTable):
    """Samples (times and values) written in the experiment file, joined by straight lines."""

    profile: Literal["table"] = "table"
    times: list[Seconds] = Field(description="increasing times [s]")
    values: list[Value] = Field(description="values at the sample times, in the input's unit")
    after: Value | Literal["hold"] = Field(0.0, description='value after the last sample, or "hold"')


class CsvTable(ProfileTable):
    """A measured time history, read from a CSV file."""

    profile: Literal["csv"] = "csv"
    path: str = Field(min_length=1, pattern=r"^[^\x00]*$", description="path of the CSV file, relative to the experiment file")
    time_column: str | int = Field(description="name of the time column, or its number from 0")
    value_column: str | int = Field(description="name of the value column, or its number from 0")
    time_unit: str | None = Field(None, description="unit of the times: s, ms, us, ns, sec, ...; default: from the CSV header")
    value_unit: str | None = Field(
        None, description="unit of the values: kN, V with a scale, ...; default: from the CSV header"
    )
    delimiter: Literal[",", ";", "\t", " "] = Field(",", description="separator of the columns")
    decimal: Literal[".", ","] = Field(".", description="decimal mark")
    skip: int = Field(0, ge=0, description="number of lines to skip at the beginning, such as the preamble of an oscilloscope")
    gaps: Literal["refuse", "bridge"] = Field(
        "refuse", description="treatment of gaps of over 10 median sampling steps: refuse them, or interpolate linearly"
    )
    scale: float | None = Field(
        None, description="factor of the values: a number, or a sensor's calibration in the input's unit per volt; default: 1"
    )
    offset_time: Seconds = Field(0.0, description="offset added to the times [s]")
    after: Value | Literal["hold"] = Field(0.0, description='value after the last sample, in SI, or "hold"')

    def make_profile(self, folder: Path, unit: str) -> Profile:
        """See `Profile.from_csv`."""
        return Profile.from_csv(**{**self.arguments(unit), "path": folder / self.path}, unit=unit, name=self.path)


class PiecewiseTable(ProfileTable):
    """A piecewise polynomial: each piece has coefficients of the powers of the time since the piece's start."""

    profile: Literal["piecewise"] = "piecewise"
    starts: list[Seconds] = Field(description="start times of the pieces [s]", examples=[[0.0, 1e-4]])
    coefficients: list[list[float]] = Field(
        description="coefficients of each piece: value, rate per second, ...", examples=[[[0.0, 5e4], [5.0]]]
    )


class SumTable(ProfileTable):
    """The sum of several profiles, each given as a table."""

    profile: Literal["sum"] = "sum"
    profiles: list[AnyProfile] = Field(
        min_length=1, description="the profiles to add", examples=[[{"profile": "constant", "value": 2.0}]]
    )

    @field_validator("profiles")
    @classmethod
    def _refuse_patterns(cls, profiles: list[ProfileTable]) -> list[ProfileTable]:
        """Refuse a `pattern` in a term: only the sum may have a pattern, which multiplies the sum of the terms."""
        for index, table in enumerate(profiles):
            if table.pattern is not None:
                raise ParameterError(
                    "got a pattern", expected="no pattern in a term of a sum; give the sum one pattern", at=(index, "pattern")
                )
        return profiles

    def make_profile(self, folder: Path, unit: str) -> Profile:
        """See `Profile.total`."""
        return Profile.total([table.make_profile(folder, unit) for table in self.profiles])


AnyProfile = Annotated[
    ConstantTable | TriangleTable | HalfSineTable | SamplesTable | CsvTable | PiecewiseTable | SumTable,
    TableChoice("profile"),
]
SumTable.model_rebuild()


def _parse_input(value: Any) -> float | list[Any] | dict[str, Any] | ProfileTable:
    """Return an input's value: a float, a list of numbers, {index: value or row}, or a profile; raise a fault for others."""
    value = value if isinstance(value, Mapping) and not _parse_elements(value) else to_si(value, None)
    if isinstance(value, list):
        return _parse_array(value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):
            return value if isinstance(value, Quantity) else float(value)
    if (elements := _parse_elements(value)) is not None:
        return elements
    if isinstance(value, Mapping | ProfileTable):
        return _PROFILE.validate_python(value)
    expected = f'a number, a list of numbers, {{index: value}}, or a table with profile = "..." ({", ".join(_PROFILE_NAMES)})'
    raise ParameterError(f"got {one_line(value)}", expected=expected)


_PROFILE: TypeAdapter[ProfileTable] = TypeAdapter(AnyProfile)
_PROFILE_NAMES = ("constant", "triangle", "half_sine", "table", "csv", "piecewise", "sum")
Input = Annotated[float | list[Any] | dict[str, Any] | ProfileTable, PlainValidator(_parse_input)]
