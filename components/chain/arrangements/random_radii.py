"""Grains whose sizes are drawn."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ...errors import ParameterError
from ...materials.elastic import Material, Preset
from ...support.counter_random import uniform
from ...support.parameter_fields import field
from ...support.validation import Parameters
from .arrangement import Arrangement, FloatArray, alternatives


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


class Random(UniformRadii, Arrangement):
    """Radii drawn evenly between two bounds: grain i's is a function of the seed and of i alone.

    The same chain as with radius = {low, high, seed}. Source: Nesterenko (1983), section 3.5.
    """

    name: Literal["random"] = "random"
    material: Preset | Material | None = field(None, "of all grains; default: the chain's", "1")

    def own_parameters(self) -> tuple[str, ...]:  # noqa: D102
        return ("radius", *super().own_parameters())

    def radii(self, host: FloatArray) -> FloatArray:  # noqa: D102
        return draw_radii(self, len(host))

    def materials(self, host: list[Material]) -> list[Material]:  # noqa: D102
        return host if self.material is None else alternatives(self.material, len(host))


def draw_radii(radii: UniformRadii, grains: int) -> FloatArray:
    """Shape (grains,) [m]."""
    return radii.low + (radii.high - radii.low) * uniform(radii.seed, 0, grains)
