"""Von Mises plasticity with linear isotropic hardening, by radial return.

q = sqrt(3/2 s:s) <= Y + H e, e the equivalent plastic strain, q the equivalent stress. A trial stress outside is scaled back
along its deviator, e' = (q - Y - H e) / (3 mu + H); the pressure stays: the return of `drucker_prager` without friction. For
plane strain with H = 0 that is exact where the direction of the strain does not turn.
Source: M. L. Wilkins, Methods in Computational Physics 3 (1964) 211.
"""

from __future__ import annotations

from typing import Literal

from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from .plastic_law import PlasticLaw


class VonMises(PlasticLaw):
    """q <= yield_stress + hardening x equivalent plastic strain."""

    name: Literal["von_mises"] = field("von_mises", "metals: yield does not depend on pressure", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at first yield", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "increase of the yield stress with equivalent plastic strain", "Pa")

    def constants(self) -> tuple[float, float, float, float]:
        """Return yield stress, hardening, no friction, no dilatancy."""
        return self.yield_stress, self.hardening, 0.0, 0.0
