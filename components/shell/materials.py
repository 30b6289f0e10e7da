"""Materials of the solid, by name: elastic, or that of Gato & Shie (2010), which flows, hardens, heats itself and softens."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import SerializeAsAny

from ..materials.elastic import PRESETS
from ..materials.thermoviscoplastic import FlowConstants, Thermoviscoplastic
from ..support.parameter_fields import Magnitude, field
from ..support.tagged_union import ByName, Named
from ..support.validation import refusal


class LinearElastic(Named):
    """Hooke's law for the Jaumann rate of the Kirchhoff stress."""

    name: Literal["elastic"] = field("elastic", "a material that never yields", "1")
    young: Magnitude = field(69e9, "Young's modulus", "Pa")
    poisson: float = field(0.33, "Poisson's ratio", "1", gt=-1.0, le=0.49)
    density: Magnitude = field(2719.0, "mass density", "kg/m^3")

    @property
    def melting_temperature(self) -> float | None:
        """None: an elastic body knows no temperature."""
        return None

    def constants(self, step_size: float) -> FlowConstants:
        """Return what kernels want to know, for ticks of this length [s]; nothing of the flow."""
        law = Thermoviscoplastic(
            young=self.young, poisson=self.poisson, density=self.density, temperature_dependent=False, softening=0.0
        )
        return law.constants(step_size)


class SolidByName(ByName):
    """Chooses the material; the name of a preset of grains is refused with the table that has its constants."""

    def choose(self, given: Any) -> Named:
        """Return the table; raise a fault where there is none, or where it is not valid."""
        preset = PRESETS.get(given) if isinstance(given, str) else None
        if preset is not None:
            constants = f"young = {preset.young:g}, poisson = {preset.poisson:g}, density = {preset.density:g}"
            raise refusal(f"got {given!r}, a preset of grains", "a law", f'give {{name = "elastic", {constants}}}')
        return super().choose(given)


SolidMaterial = LinearElastic | Thermoviscoplastic
ChosenMaterial = Annotated[
    SerializeAsAny[SolidMaterial], SolidByName({"elastic": LinearElastic, "thermoviscoplastic": Thermoviscoplastic})
]
