"""Cold welding: a contact that is pressed hard and hardly slides becomes a link.

    N / S' >= pressure        and        |sliding speed| <= slip_speed

The switching unlinked -> linked of movable cellular automata: Psakhie et al. (2003), section 2.2. Pairs that the packing linked
once are linked again, where their line of centres lies within 45 degrees of the axis of their link. The new link carries what
the contact carried, and its strains count from there.
"""

from __future__ import annotations

from typing import Literal

from ...support.parameter_fields import Magnitude, field
from .relinking import Relinking


class ColdWelding(Relinking):
    """Pressure of the contact >= pressure, and sliding speed <= slip_speed; looked at every `release_ticks` steps."""

    name: Literal["cold_welding"] = field("cold_welding", "which law", "1")
    pressure: Magnitude = field(..., "pressure of a contact that links it", "Pa")
    slip_speed: Magnitude = field(..., "largest sliding speed at which it does", "m/s")
    kinds = {"linked": "a broken pair was pressed as hard as its law says, and was linked again"}

    def constants(self) -> tuple[float, float]:
        """Return pressure and speed."""
        return self.pressure, self.slip_speed
