"""Kinds of fields that the parameters of the grid share."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from ..errors import nearest
from ..materials.elastic import PRESETS


def _preset(name: str) -> str:
    if name not in PRESETS:
        raise ValueError(f"{name!r} is no preset; {nearest(name, PRESETS)}; or give density, young and poisson")
    return name


Preset = Annotated[str, AfterValidator(_preset)]
Positive = Annotated[float, Field(gt=0.0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
PositivePair = Annotated[list[Positive], Field(min_length=2, max_length=2)]
Index = Annotated[int, Field(ge=0)]


def field(default: Any, description: str, unit: str, **bounds: Any) -> Any:
    """Return a parameter with its meaning and unit."""
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)
