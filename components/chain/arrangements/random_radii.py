"""Grains whose sizes are drawn."""

from __future__ import annotations

from typing import Literal

from ...materials.elastic import Material, Preset
from ...support.counter_random import uniform
from ...support.parameter_fields import field
from ..radius_distribution import UniformRadii
from .arrangement import Arrangement, FloatArray, alternatives


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
