"""Bounds and seed of radii that are drawn evenly between two bounds."""

from __future__ import annotations

from pydantic import model_validator

from ..errors import ParameterError
from ..support.parameter_fields import field
from ..support.validation import Parameters


class UniformRadii(Parameters):
    """Radii drawn evenly between two bounds, a function of the seed (the RAND of Nesterenko's section 3.5)."""

    low: float = field(..., "smallest radius", "m", gt=0.0)
    high: float = field(..., "largest radius", "m", gt=0.0)
    seed: int = field(0, "which draw", "1", ge=0, lt=2**63)

    @model_validator(mode="after")
    def _validate_order(self) -> UniformRadii:
        if self.high < self.low:
            raise ParameterError(f"got {self.high:g} m", expected=f"at least low = {self.low:g} m", at="high")
        return self
