"""A point parts where its plastic strain passes a limit, while its largest principal stress is above half the yield stress."""

from __future__ import annotations

from typing import ClassVar, Literal

from ...materials.thermoviscoplastic import FlowConstants
from ...support.parameter_fields import Magnitude, field
from .law import Decisive, FractureLaw


class PlasticStrain(FractureLaw):
    """The equivalent plastic strain decides, where the largest principal stress is above half the yield stress."""

    decisive: ClassVar[Decisive] = Decisive.PLASTIC_STRAIN
    unit: ClassVar[str] = "1"
    quantity: ClassVar[str] = "the plastic strain"
    name: Literal["plastic_strain"] = field("plastic_strain", "the equivalent plastic strain decides", "1")
    strain: Magnitude = field(0.3, "plastic strain at which a point in tension parts", "1")

    @property
    def needs_flow(self) -> bool:
        """True: only what flows has a plastic strain."""
        return True

    def limit(self, law: FlowConstants) -> float:
        """Return the plastic strain at which a point parts."""
        return self.strain
