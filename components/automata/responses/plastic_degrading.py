"""Plastic flow and degradation together: figure 3, d."""

from __future__ import annotations

from typing import Literal

from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .response import Response


class PlasticDegrading(Response):
    """Beyond the yield stress a pair flows and its modulus falls; unloading is flatter and leaves a strain."""

    name: Literal["plastic_degrading"] = field("plastic_degrading", "which response", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at which flow and degradation begin", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the equivalent stress over the inelastic strain", "Pa")
    degradation: float = field(0.5, "part of the excess that degrades the modulus, the rest is plastic", "1", ge=0.0, le=1.0)

    def constants(self) -> tuple[float, float, float]:
        """Return yield stress, slope, and part."""
        return self.yield_stress, self.hardening, self.degradation
