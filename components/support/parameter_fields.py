"""Field types and bounds that the parameter models of components share."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Index = Annotated[int, Field(ge=0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
PositivePair = Annotated[list[Positive], Field(min_length=2, max_length=2)]


def field(default: Any, description: str, unit: str, **bounds: Any) -> Any:
    """Return a parameter with its meaning and unit."""
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)
