"""Kinds of fields that the chain's parameters and its arrangements share."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from ..errors import nearest
from ..materials.elastic import PRESETS
from ..support.validation import Parameters


def _preset(name: str) -> str:
    if name not in PRESETS:
        raise ValueError(f"{name!r} is no preset; {nearest(name, PRESETS)}; or give density, young and poisson")
    return name


Preset = Annotated[str, AfterValidator(_preset)]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
GrainIndex = Annotated[int, Field(ge=0)]


def field(default, description: str, unit: str, **bounds):  # noqa: ANN001, ANN003, ANN201
    """Return a parameter with its meaning and unit."""
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)


class UniformRadii(Parameters):
    """Radii drawn evenly between two bounds, a function of the seed (the RAND of Nesterenko's section 3.5)."""

    low: float = field(..., "smallest radius", "m", gt=0.0)
    high: float = field(..., "largest radius", "m", gt=0.0)
    seed: int = field(0, "which draw", "1", ge=0, lt=2**63)

    @model_validator(mode="after")
    def _validate_order(self) -> UniformRadii:
        if self.high < self.low:
            raise ValueError(f"high: got {self.high:g} m, expected at least low = {self.low:g} m")
        return self
