"""A point cracks if its plastic strain passes a limit while its largest principal stress is above half the yield stress."""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from ....materials.thermoviscoplastic import FlowConstants
from ....support.parameter_fields import Magnitude, field
from .fracture_law import FractureLaw, decisive_value, may_exceed

# The largest principal stress at a point that cracks must exceed this fraction of the yield stress.
_TENSION = 0.5


class PlasticStrainConstants(NamedTuple):
    """The stress [Pa] that the largest principal stress must exceed at a point that cracks, so that unloaded points do not."""

    tension: float


class PlasticStrain(FractureLaw):
    """The equivalent plastic strain is tested, if the largest principal stress is above half the yield stress."""

    unit: ClassVar[str] = "1"
    quantity: ClassVar[str] = "the plastic strain"
    name: Literal["plastic_strain"] = field("plastic_strain", "limit of the equivalent plastic strain", "1")
    strain: Magnitude = field(0.3, "plastic strain at which a point in tension parts", "1")

    @property
    def needs_flow(self) -> bool:
        """True: an elastic material has no plastic strain."""
        return True

    def limit(self, law: FlowConstants) -> float:
        """Return the plastic strain at which a point cracks."""
        return self.strain

    def constants(self, law: FlowConstants) -> PlasticStrainConstants:
        """Return the largest principal stress below which no point cracks."""
        return PlasticStrainConstants(_TENSION * law.yield_stress)


@decisive_value.register(PlasticStrainConstants)
def _strain_in_tension(law, point):
    return point.plastic_strain if point.principal > law.tension else 0.0


@may_exceed.register(PlasticStrainConstants)
def _may_exceed(law, value, stress, plastic_strain):
    return plastic_strain > value
