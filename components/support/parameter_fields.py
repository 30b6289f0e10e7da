"""Field types and bounds that the parameter models of components share."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field
from pydantic.fields import FieldInfo

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Index = Annotated[int, Field(ge=0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
PositivePair = Annotated[list[Positive], Field(min_length=2, max_length=2)]


def field(default: Any, description: str, unit: str, *, without: str | None = None, **bounds: Any) -> Any:
    """Return a parameter with its meaning and unit; `without` says what its absence means where nothing is worked out then."""
    told: dict[str, Any] = {"unit": unit} if without is None else {"unit": unit, "left_out": without}
    return Field(default, description=description, json_schema_extra=told, **bounds)


def unit_of(field: FieldInfo) -> str:
    """Return the unit that a parameter declares."""
    return _extra(field, "unit", "")


def left_out(field: FieldInfo) -> str:
    """Return what it means that a parameter has no value: that it is worked out, or that there is nothing of it."""
    return _extra(field, "left_out", "automatic")


def _extra(field: FieldInfo, what: str, otherwise: str) -> str:
    extra = field.json_schema_extra
    return str(extra.get(what, otherwise)) if isinstance(extra, dict) else otherwise
