"""A small grain between any two large ones."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...errors import ParameterError
from ...materials.elastic import Material, Preset, material
from ...support.parameter_fields import Positive, field
from .arrangement import Arrangement, FloatArray
from .tapered import geometric, sound_radii


class Decorated(Arrangement):
    """Large, small, large, ..., large: an odd number of grains. The large ones may be tapered, the small ones are equal.

    Source: R. L. Doney, S. Sen, Phys. Rev. Lett. 97, 155502 (2006): decorated, tapered chains as impulse absorbers.
    """

    name: Literal["decorated"] = "decorated"
    radius: Positive = field(..., "of the large grains; of the first one, where they are tapered", "m")
    decoration_radius: Positive = field(..., "of the small grains", "m")
    taper: float = field(0.0, "q of R_(i+1) = (1 - q) R_i, from one large grain to the next", "1", gt=-1.0, lt=1.0)
    material: Preset | Material | None = field(None, "of the large grains; default: the chain's", "1")
    decoration_material: Preset | Material | None = field(None, "of the small grains; default: that of the large ones", "1")

    def fit(self, grains: int) -> None:  # noqa: D102
        if grains < 3 or grains % 2 == 0:
            raise ParameterError(
                f"'decorated' does not fit {grains} grains",
                hint="expected an odd number from 3: a large one at each end",
                at="name",
            )
        smallest = min(self.radius, sound_radii(self.radius, 1.0 - self.taper, grains // 2 + 1))
        # Equal large and small grains are one size, whatever rounding made of the last one.
        if smallest * (1.0 + 1e-12) < self.decoration_radius:
            raise ParameterError(
                f"got {self.decoration_radius:g} m",
                expected=f"at most the smallest of the large grains, {smallest:g} m",
                at="decoration_radius",
            )

    def radii(self, host: FloatArray) -> FloatArray:  # noqa: D102
        radius = np.full(len(host), self.decoration_radius)
        radius[::2] = geometric(self.radius, 1.0 - self.taper, len(host) // 2 + 1)
        return radius

    def materials(self, host: list[Material]) -> list[Material]:  # noqa: D102
        if self.material is None and self.decoration_material is None:
            return host
        large = [material(self.material)] * len(host) if self.material is not None else list(host)
        if self.decoration_material is not None:
            large[1::2] = [material(self.decoration_material)] * (len(host) // 2)
        return large
