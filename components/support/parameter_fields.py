"""Types of parameter fields: units, bounds, and magnitudes whose squares and products stay finite."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, Field
from pydantic.fields import FieldInfo

from ..errors import Location, ParameterError

# Bounds of lengths, moduli and similar constants.
LEAST, MOST = 1e-40, 1e40


def refuse_extreme_values(values: Iterable[tuple[Location, float]]) -> None:
    """Raise an error for a positive number below `LEAST` or above `MOST`; `values` gives pairs of location and number."""
    for location, value in values:
        if not LEAST <= value <= MOST:
            raise ParameterError(f"got {value:g}", expected=f"{LEAST:g} to {MOST:g}", at=location)


def refuse_extreme_coordinates(values: Iterable[tuple[Location, float]]) -> None:
    """Raise an error for a coordinate with a magnitude above `MOST`; `values` gives pairs of location and coordinate."""
    for location, value in values:
        if not abs(value) <= MOST:
            raise ParameterError(f"got {value:g}", expected=f"{-MOST:g} to {MOST:g}", at=location)


def _validate_magnitude(value: float) -> float:
    if value != 0.0:
        refuse_extreme_values([((), abs(value))])
    return value


def _validate_coordinate(value: float) -> float:
    refuse_extreme_coordinates([((), value)])
    return value


Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Index = Annotated[int, Field(ge=0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
PositivePair = Annotated[list[Positive], Field(min_length=2, max_length=2)]
# The types above, restricted to magnitudes within `LEAST` and `MOST`.
Magnitude = Annotated[float, Field(gt=0.0), AfterValidator(_validate_magnitude)]
NotNegativeMagnitude = Annotated[float, Field(ge=0.0), AfterValidator(_validate_magnitude)]
SignedMagnitude = Annotated[float, AfterValidator(_validate_coordinate)]
SignedPair = Annotated[list[SignedMagnitude], Field(min_length=2, max_length=2)]


def field(default: Any, description: str, unit: str, *, absent: str | None = None, **bounds: Any) -> Any:
    """Return a parameter field with description and unit; `absent` is the meaning of an omitted value that is not computed."""
    extra: dict[str, Any] = {"unit": unit} if absent is None else {"unit": unit, "left_out": absent}
    return Field(default, description=description, json_schema_extra=extra, **bounds)


def field_unit(field: FieldInfo) -> str:
    """Return the unit that a parameter declares."""
    return _declared_text(field, "unit", "")


def absent_meaning(field: FieldInfo) -> str:
    """Return the meaning of an omitted value: "automatic" if it is computed, or the declared text."""
    return _declared_text(field, "left_out", "automatic")


def _declared_text(field: FieldInfo, key: str, default: str) -> str:
    extra = field.json_schema_extra
    return str(extra.get(key, default)) if isinstance(extra, dict) else default
