"""Degradation of the shear modulus: figure 3, b. The modulus for a change of volume stays lambda + 2 g G / 3."""

from __future__ import annotations

from typing import Literal

from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .response import Response


class Degrading(Response):
    """Beyond the onset the modulus falls; unloading goes straight back to the origin."""

    name: Literal["degrading"] = field("degrading", "which response", "1")
    onset: Magnitude = field(..., "equivalent stress sigma_d at which degradation begins", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the equivalent stress over the inelastic strain", "Pa")

    def constants(self) -> tuple[float, float, float]:
        """Return onset, slope, and all of the excess."""
        return self.onset, self.hardening, 1.0
