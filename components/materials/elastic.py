"""Linear elastic, isotropic materials."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationError

from ..errors import Location, ParameterError, one_line, spelling_hint
from ..support.validation import Fixed, validation_faults


class Material(Fixed):
    """A linear elastic, isotropic material.

    Attributes:
        density: mass density [kg/m^3].
        young: Young's modulus [Pa].
        poisson: Poisson's ratio, more than -1 and less than 0.5.
        yield_strength: yield strength in compression, or None if unknown [Pa].
    """

    density: float = Field(gt=0.0, description="mass density", json_schema_extra={"unit": "kg/m^3"})
    young: float = Field(gt=0.0, description="Young's modulus", json_schema_extra={"unit": "Pa"})
    poisson: float = Field(gt=-1.0, lt=0.5, description="Poisson's ratio", json_schema_extra={"unit": "1"})
    yield_strength: float | None = Field(
        default=None,
        gt=0.0,
        description="yield strength in compression, for validity figures and the contact law elastic_plastic",
        json_schema_extra={"unit": "Pa"},
    )

    def __init__(self, **fields: Any) -> None:
        """Check the fields.

        Raises:
            ParameterError: a constant is missing, unknown or out of range.
        """
        try:
            super().__init__(**fields)
        except ValidationError as error:
            raise ParameterError(
                *(fault.with_source("Material") for fault in validation_faults(error, fields, type(self)))
            ) from None

    @property
    def plane_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa], the compliance of the material in a Hertz contact."""
        return (1.0 - self.poisson * self.poisson) / self.young

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E / (2 (1 + nu)) [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def first_lame(self) -> float:
        """Lame's first constant E nu / ((1 + nu)(1 - 2 nu)) [Pa]."""
        return self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))

    @property
    def shear_speed(self) -> float:
        """Speed of shear waves sqrt(shear modulus / density) [m/s]."""
        return math.sqrt(self.shear_modulus / self.density)

    @property
    def longitudinal_speed(self) -> float:
        """Speed of longitudinal sound sqrt(E (1 - nu) / (rho (1 + nu)(1 - 2 nu))) [m/s]."""
        young, poisson, density = self.young, self.poisson, self.density
        return math.sqrt(young * (1.0 - poisson) / (density * (1.0 + poisson) * (1.0 - 2.0 * poisson)))


def rayleigh_speed(material: Material) -> float:
    """Return the speed of Rayleigh waves [m/s]: (2 - x)^2 = 4 sqrt((1 - x)(1 - k x)), x = (c / c_s)^2, k = (c_s / c_p)^2.

    Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), equation (5.95).
    """
    ratio = material.shear_speed / material.longitudinal_speed
    k, low, high = ratio * ratio, 0.1, 1.0
    # Left side minus right side is negative from x > 0 to the root, and positive from there to x = 1.
    for _ in range(200):
        middle = 0.5 * (low + high)
        difference = (2.0 - middle) * (2.0 - middle) - 4.0 * math.sqrt((1.0 - middle) * (1.0 - k * middle))
        low, high = (middle, high) if difference < 0.0 else (low, middle)
    return math.sqrt(low) * material.shear_speed


# Steel: the constants of Nesterenko (1983), section 3.5; yield of hardened bearing steel (AISI 52100). The others:
# usual handbook values of the grades that chain experiments use (ASM Handbook; brass C26000, aluminium 6061-T6,
# soda-lime glass, PTFE).
PRESETS = {
    "steel": Material(density=7800.0, young=2.0e11, poisson=0.29, yield_strength=2.0e9),
    "aluminium": Material(density=2700.0, young=6.9e10, poisson=0.33, yield_strength=2.76e8),
    "brass": Material(density=8530.0, young=1.1e11, poisson=0.35, yield_strength=3.6e8),
    "glass": Material(density=2500.0, young=7.0e10, poisson=0.22),
    "ptfe": Material(density=2200.0, young=1.46e9, poisson=0.46),
}


def material_constants(material: str | Material | list[str | Material]) -> Iterator[tuple[Location, float]]:
    """Yield density and Young's modulus of each material in a parameter `material`, with their locations."""
    for place, one in enumerate(material if isinstance(material, list) else [material]):
        if isinstance(one, Material):
            where: Location = ("material", place) if isinstance(material, list) else ("material",)
            yield (*where, "density"), one.density
            yield (*where, "young"), one.young


def _preset_error(name: object) -> ParameterError:
    hint = spelling_hint(str(name), PRESETS, "or give density, young and poisson")
    return ParameterError(f"got {one_line(name)}", expected="the name of a preset", hint=hint)


def _validate_preset(name: str) -> str:
    if name not in PRESETS:
        raise _preset_error(name)
    return name


Preset = Annotated[str, AfterValidator(_validate_preset)]
"""Parameter type: the name of a preset."""


def preset_text() -> str:
    """Return the presets and their constants, in one line."""
    return "; ".join(
        f"{name}: {one.density:g} kg/m^3, {one.young / 1e9:g} GPa, nu {one.poisson:g}, "
        + (f"yield {one.yield_strength / 1e6:g} MPa" if one.yield_strength else "yield unknown")
        for name, one in PRESETS.items()
    )


def to_material(value: str | Material) -> Material:
    """Return the preset material with a given name; a `Material` is returned unchanged."""
    if isinstance(value, Material):
        return value
    if not isinstance(value, str) or value not in PRESETS:
        raise _preset_error(value).with_outer_location("material")
    return PRESETS[value]
