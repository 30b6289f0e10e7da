"""Plastic flow without change of volume: figure 3, c."""

from __future__ import annotations

from typing import Literal

from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .response import Response


class Plastic(Response):
    """Beyond the yield stress a pair flows; unloading is elastic and leaves a strain."""

    name: Literal["plastic"] = field("plastic", "which response", "1")
    yield_stress: Magnitude = field(..., "equivalent stress sigma_y at which flow begins", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the yield stress over the plastic strain", "Pa")

    def constants(self) -> tuple[float, float, float]:
        """Return yield stress, slope, and nothing of the excess."""
        return self.yield_stress, self.hardening, 0.0
