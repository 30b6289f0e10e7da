"""The columns that measurements on a chain can add to a sweep's table; each is a function(history, which, arguments)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from granular_env.domains.chain import measurement

Taken = Callable[[Any, int, dict[str, Any]], float]
"""A column: function(history, which, arguments) that returns a number, NaN if the measurement has no item `which`."""


def measurement_function(name: str) -> Callable[..., Any]:
    """Return the function of `measurement` with this name."""
    return getattr(measurement, name)


def _value_column(name: str, convert: Callable[[Any], float] = float) -> Taken:
    """Return a column with `convert` of the measurement's result; for a list, `convert` is `len`, its number of items."""

    def column(history: Any, which: int, arguments: dict[str, Any]) -> float:
        return float(convert(getattr(measurement, name)(history, **arguments)))

    return column


def _attribute_column(name: str, attribute: str) -> Taken:
    """Return a column with an attribute of the measurement's result or, if that is a list, of its item number `which`."""

    def column(history: Any, which: int, arguments: dict[str, Any]) -> float:
        found = getattr(measurement, name)(history, **arguments)
        if isinstance(found, list):
            if not -len(found) <= which < len(found):
                return math.nan
            found = found[which]
        return float(getattr(found, attribute))

    return column


def _wave_column(function: str) -> Taken:
    """Return a column with the result of `function` (`energy_of` or `momentum_of`) for wave number `which` of `waves_at`."""

    def column(history: Any, which: int, arguments: dict[str, Any]) -> float:
        waves = measurement.waves_at(history, **arguments)
        return float(getattr(measurement, function)(history, waves[which])) if -len(waves) <= which < len(waves) else math.nan

    return column


def _attribute_columns(name: str, *attributes: str) -> dict[str, Taken]:
    return {attribute: _attribute_column(name, attribute) for attribute in attributes}


MEASUREMENTS: dict[str, dict[str, Taken]] = {
    "waves_at": {
        "count": _value_column("waves_at", len),
        **_attribute_columns("waves_at", "amplitude", "speed", "time", "duration", "width"),
        "energy": _wave_column("energy_of"),
        "momentum": _wave_column("momentum_of"),
    },
    "waves_along": {
        "count": _value_column("waves_along", len),
        **_attribute_columns(
            "waves_along", "amplitude", "position", "energy", "kinetic_energy", "potential_energy", "momentum"
        ),
    },
    "front_speed": {"value": _value_column("front_speed")},
    "pressure_ratio": _attribute_columns("pressure_ratio", "ratio", "first_maximum", "settled"),
    "energy_ratio": _attribute_columns("energy_ratio", "mean", "least", "greatest", "deviation"),
    "momentum_carried_off": {"value": _value_column("momentum_carried_off")},
    "detached_grains": {"count": _value_column("detached_grains", len)},
}

# Unit of a column by its name, or by (measurement, column name) where columns of equal name have different units.
UNITS: dict[str | tuple[str, str], str] = {
    **dict.fromkeys(("count", "ratio", "mean", "least", "greatest", "deviation"), "1"),
    **dict.fromkeys(("amplitude", "speed"), "m/s"),
    **dict.fromkeys(("time", "duration"), "s"),
    "width": "m",
    "position": "m",
    **dict.fromkeys(("energy", "kinetic_energy", "potential_energy"), "J"),
    "momentum": "kg m/s",
    **dict.fromkeys(("first_maximum", "settled"), "N"),
    ("front_speed", "value"): "m/s",
    ("momentum_carried_off", "value"): "1",
}
