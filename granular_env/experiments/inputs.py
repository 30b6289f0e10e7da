"""Inputs of an experiment file: a number, or a table that names a profile of time.

    [input.left_force]
    profile = "triangle"      # constant, triangle, half_sine, table, csv, piecewise, sum
    peak = 2000.0
    duration = 1e-4

Times are in seconds, values in the input's own SI unit; only a CSV file declares other units.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, SerializeAsAny

from granular_env.components.errors import nearest
from granular_env.components.profiles import Profile

from .faults import Faults, Table, shortened

_DEEPEST_SUM = 8
# What people write for a CSV table's path; no spelling check would find it.
_WORDS_FOR_PATH = ("file", "filename", "csv", "name")

# Signals that have no profile of their own; the nearest name, half_sine, would be something else.
_WAVES = ("sin", "cos", "chirp", "sweep", "gauss", "burst", "harmonic", "ricker", "wavelet", "noise")
_HALF_SINES = ("halfsine", "half-sine", "half sine", "half_sin", "halfsin", "half-sin")
_SAMPLED = 'give samples of other signals: profile = "table" with times and values, or "csv"'


class ProfileTable(Table, ABC):
    """One profile as a table; `build` makes the `Profile`. Each kind has its name as the field `profile`."""

    @abstractmethod
    def build(self, folder: Path, unit: str) -> Profile:
        """The profile, for an input of that unit; paths are relative to `folder`."""


class ConstantTable(ProfileTable):
    """`value` from `start` on."""

    profile: Literal["constant"] = "constant"
    value: float = Field(description="the input's value, in its unit")
    start: float = Field(0.0, description="when it begins [s]")

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.constant`."""
        return Profile.constant(self.value, self.start)


class TriangleTable(ProfileTable):
    """From 0 to `peak` in `rise`, back to 0 at `duration`; with rise = 0 it falls from the peak."""

    profile: Literal["triangle"] = "triangle"
    peak: float = Field(description="the greatest value, in the input's unit")
    duration: float = Field(description="from first to last [s]")
    rise: float = Field(0.0, description="from 0 to the peak [s]")
    start: float = Field(0.0, description="when it begins [s]")

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.triangle`."""
        return Profile.triangle(self.peak, self.duration, self.rise, self.start)


class HalfSineTable(ProfileTable):
    """Half a sine wave."""

    profile: Literal["half_sine"] = "half_sine"
    peak: float = Field(description="the greatest value, in the input's unit")
    duration: float = Field(description="from zero to zero [s]")
    start: float = Field(0.0, description="when it begins [s]")

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.half_sine`."""
        return Profile.half_sine(self.peak, self.duration, self.start)


class SamplesTable(ProfileTable):
    """Straight lines between samples written in the file."""

    profile: Literal["table"] = "table"
    times: list[float] = Field(description="increasing [s]")
    values: list[float] = Field(description="one for each time, in the input's unit")
    after: float | Literal["hold"] = Field(0.0, description='the value after the last sample, or "hold"')

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.table`."""
        return Profile.table(self.times, self.values, self.after)


class CsvTable(ProfileTable):
    """A measured history in a CSV file; see `Profile.from_csv`."""

    profile: Literal["csv"] = "csv"
    path: str = Field(min_length=1, description="the CSV file, relative to the experiment's")
    time_column: str | int = Field(description="the time column's name, or its number from 0")
    value_column: str | int = Field(description="the value column's name, or its number from 0")
    time_unit: str | None = Field(None, description="s, ms, us or ns; may stand in the CSV's header instead")
    value_unit: str | None = Field(
        None, description="such as kN or mm/s, or V with a scale; may stand in the CSV's header instead"
    )
    delimiter: Literal[",", ";", "\t"] = Field(",", description="what separates the columns")
    decimal: Literal[".", ","] = Field(".", description="the decimal mark")
    skip: int = Field(0, ge=0, description="lines to leave out at the beginning, such as the preamble of an oscilloscope")
    gaps: Literal["refuse", "bridge"] = Field(
        "refuse", description="holes in the sampling, of over 10 median steps: refuse them, or cross them in a straight line"
    )
    scale: float | None = Field(
        None, description="the values are multiplied by it: a number, or the input's unit for each volt of a sensor"
    )
    offset_time: float = Field(0.0, description="added to the times [s]")
    after: float | Literal["hold"] = Field(0.0, description='the value after the last sample, in SI, or "hold"')

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.from_csv`."""
        keys = self.model_dump(exclude={"profile", "path"})
        return Profile.from_csv(folder / self.path, unit=unit, **keys)


class PiecewiseTable(ProfileTable):
    """Polynomials by hand: each piece in powers of the time since it began."""

    profile: Literal["piecewise"] = "piecewise"
    starts: list[float] = Field(description="when each piece begins [s]")
    coefficients: list[list[float]] = Field(description="for each piece, the value, its rate per second, ...")

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.piecewise`."""
        return Profile.piecewise(self.starts, self.coefficients)


class SumTable(ProfileTable):
    """Several profiles added up."""

    profile: Literal["sum"] = "sum"
    profiles: list[SerializeAsAny[ProfileTable]] = Field(min_length=1, description="the tables to add")

    def build(self, folder: Path, unit: str) -> Profile:
        """See `Profile.total`."""
        return Profile.total([table.build(folder, unit) for table in self.profiles])


PROFILES: dict[str, type[ProfileTable]] = {
    "constant": ConstantTable,
    "triangle": TriangleTable,
    "half_sine": HalfSineTable,
    "table": SamplesTable,
    "csv": CsvTable,
    "piecewise": PiecewiseTable,
    "sum": SumTable,
}


def parse_input(value: Any, place: str, faults: Faults) -> float | ProfileTable | None:
    """A number or a profile from what the file says; None, and a fault added, where it is neither."""
    if isinstance(value, Mapping):
        return _parse_profile(value, place, faults, _DEEPEST_SUM)
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            pass
    faults.add(place, f'got {shortened(value)}, expected a number, or a table with profile = "..." ({", ".join(PROFILES)})')
    return None


def _parse_profile(table: Mapping[str, Any], place: str, faults: Faults, depth: int) -> ProfileTable | None:
    kind = table.get("profile")
    model = PROFILES.get(kind) if isinstance(kind, str) else None
    if model is None:
        came = "missing" if kind is None else f"got {shortened(kind)}"
        waves = isinstance(kind, str) and any(word in kind.lower() for word in _WAVES) and kind.lower() not in _HALF_SINES
        advice = f"known: {', '.join(PROFILES)}; {_SAMPLED}" if waves else nearest(str(kind), PROFILES)
        faults.add(f"{place}.profile", f"{came}; {advice}")
        return None
    other = next((word for word in _WORDS_FOR_PATH if word in table), None)
    if model is CsvTable and other is not None and "path" not in table:
        faults.add(f"{place}.{other}", "unknown; did you mean 'path'?")
        return None
    parts = table.get("profiles")
    if model is SumTable and isinstance(parts, list):
        if depth == 0:
            faults.add(place, f"sums of sums go {_DEEPEST_SUM} deep at most")
            return None
        parsed = [_part(part, f"{place}.profiles.{index}", faults, depth - 1) for index, part in enumerate(parts)]
        if None in parsed:
            return None
        table = {**table, "profiles": parsed}
    return faults.table(model, table, place)


def _part(part: Any, place: str, faults: Faults, depth: int) -> ProfileTable | None:
    if isinstance(part, Mapping):
        return _parse_profile(part, place, faults, depth)
    faults.add(place, f'got {shortened(part)}, expected a table with profile = "..."')
    return None
