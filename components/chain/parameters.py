"""Parameters of the granular chain."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from ..contract import Parameters
from ..errors import nearest
from ..materials.elastic import PRESETS, Material
from .laws import AnyLaw, Hertz

Boundary = Literal["free", "piston", "fixed_grain", "plane", "rigid_plane"]
WALLS = ("fixed_grain", "plane", "rigid_plane")
Integrator = Literal["pefrl", "leapfrog", "rk4", "hamming", "dop853"]

_MAXIMUM_GRAINS = 100_000_000


def _preset(name: str) -> str:
    if name not in PRESETS:
        raise ValueError(f"{name!r} is no preset; {nearest(name, PRESETS)}; or give density, young and poisson")
    return name


Preset = Annotated[str, AfterValidator(_preset)]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
GrainIndex = Annotated[int, Field(ge=0)]


class UniformRadii(Parameters):
    """Radii drawn evenly between two bounds, a function of the seed (the RAND of Nesterenko's section 3.5)."""

    low: float = Field(gt=0.0, description="smallest radius", json_schema_extra={"unit": "m"})
    high: float = Field(gt=0.0, description="largest radius", json_schema_extra={"unit": "m"})
    seed: int = Field(0, ge=0, lt=2**63, description="which draw", json_schema_extra={"unit": "1"})

    @model_validator(mode="after")
    def _ordered(self) -> UniformRadii:
        if self.high < self.low:
            raise ValueError(f"high: got {self.high:g} m, expected at least low = {self.low:g} m")
        return self


def _field(default, description: str, unit: str, **bounds):  # noqa: ANN001, ANN202, ANN003
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)


class ChainParameters(Parameters):
    """A row of elastic spheres that touch by Hertz's law, with its two ends."""

    grains: int = _field(..., "number of grains", "1", ge=1, le=_MAXIMUM_GRAINS)
    radius: Positive | list[Positive] | UniformRadii = _field(3e-3, "radius: one for all, one each, or drawn", "m")
    material: Preset | Material | list[Preset | Material] = _field(
        "steel", "preset name or material: one for all, or one each", "1"
    )
    mass: Positive | list[Positive] | dict[GrainIndex, Positive] | None = _field(
        None, "mass instead of density x volume: one for all, one each, or {index: mass}", "kg"
    )
    contact_stiffness: Positive | list[Positive] | None = _field(
        None,
        "Hertz stiffness k of F = k overlap^1.5 instead of the materials': one for all, or one for each contact",
        "N/m^1.5",
    )
    law: AnyLaw = _field(Hertz(), "contact law: its name, or a table of its name and parameters", "1")
    gravity: float = _field(0.0, "acceleration of all grains, positive to the right", "m/s^2", ge=-1e6, le=1e6)
    gap: NotNegative | list[NotNegative] = _field(0.0, "gap at the start: one for all contacts, or one each", "m")
    precompression: float = _field(0.0, "static force that presses the chain together at the start", "N", ge=0.0, le=1e60)
    left: Boundary = _field("free", "left end: free, piston (the end grain's velocity is prescribed), or a wall", "1")
    right: Boundary = _field("free", "right end: free, piston (the end grain's velocity is prescribed), or a wall", "1")
    left_wall_material: Preset | Material | None = _field(None, "material of the left wall; default the first grain's", "1")
    right_wall_material: Preset | Material | None = _field(None, "material of the right wall; default the last grain's", "1")
    integrator: Integrator = _field("pefrl", "pefrl, leapfrog, rk4, hamming or dop853 (reference)", "1")
    step_size: Positive | None = _field(None, "internal step; default suggested from stiffness, mass and velocity_scale", "s")
    velocity_scale: float = _field(
        10.0, "largest relative speed of neighbours to expect, for the suggested step", "m/s", ge=1e-9, le=1e9
    )
    tolerance: float = _field(1e-12, "relative error a step of dop853 may make", "1", ge=1e-15, le=1e-3)
    overlap_limit: float = _field(0.1, "overlap, as a part of the smaller radius, at which a step is refused", "1", gt=0.0)

    @model_validator(mode="after")
    def _shapes(self) -> ChainParameters:
        for name, count, what in (
            ("radius", self.grains, "grain"),
            ("material", self.grains, "grain"),
            ("mass", self.grains, "grain"),
            ("contact_stiffness", self.contacts, "contact"),
            ("gap", self.contacts, "contact"),
        ):
            value = getattr(self, name)
            if isinstance(value, list) and len(value) != count:
                raise ValueError(f"{name}: got {len(value)} values, expected one for all or {count}, one for each {what}")
        if isinstance(self.mass, dict) and any(index >= self.grains for index in self.mass):
            raise ValueError(f"mass: got index {max(self.mass)}, expected 0 to {self.grains - 1}")
        for side in ("left", "right"):
            if getattr(self, f"{side}_wall_material") is not None and getattr(self, side) not in WALLS:
                raise ValueError(
                    f"{side}_wall_material: there is no wall, {side} is {getattr(self, side)!r}; "
                    f"expected {side} to be one of {', '.join(WALLS)}"
                )
            if getattr(self, f"{side}_wall_material") is not None and getattr(self, side) == "rigid_plane":
                raise ValueError(f"{side}_wall_material: a rigid plane has none; give {side} = 'plane' or leave it out")
        if self.law.needs_stiffness and self.contact_stiffness is None:
            raise ValueError(
                f"contact_stiffness: law {self.law.name!r} needs it, in N/m^exponent; "
                "radii and materials tell it for spheres only"
            )
        for name in ("dissipation", "yield_pressure"):
            value = getattr(self.law, name, None)
            if isinstance(value, list) and len(value) != self.contacts:
                raise ValueError(
                    f"law.{name}: got {len(value)} values, expected one for all or {self.contacts}, one for each contact"
                )
        if "piston" in (self.left, self.right) and self.grains == 1:
            raise ValueError("grains: got 1, expected at least 2 where an end is a piston: it needs a grain to push")
        gaps = self.gap if isinstance(self.gap, list) else [self.gap]
        if self.precompression > 0.0 and any(gap > 0.0 for gap in gaps):
            raise ValueError("gap: a precompressed chain has none; give gap = 0 or precompression = 0")
        return self

    @property
    def contacts(self) -> int:
        """Number of contacts: between neighbours, and one with each wall."""
        return self.grains - 1 + (self.left in WALLS) + (self.right in WALLS)
