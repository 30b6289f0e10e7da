"""Parameters of the granular chain."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ..errors import ParameterError, one_line
from ..materials.elastic import Material, Preset, preset_text
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray
from ..support.parameter_fields import Index, NotNegative, Positive
from ..support.parameter_fields import field as _field
from ..support.validation import Parameters
from .arrangements import ChosenArrangement, Uniform, refuse_unfit_arrangement
from .laws import ChosenLaw, Hertz
from .laws.law import refuse_incomplete

__all__ = ["WALLS", "Boundary", "ChainParameters", "Integrator", "UniformRadii"]

Boundary = Literal["free", "piston", "fixed_grain", "plane", "rigid_plane"]
WALLS = ("fixed_grain", "plane", "rigid_plane")
Integrator = Literal["pefrl", "leapfrog", "rk4", "hamming"]

_MAXIMUM_GRAINS = 100_000_000


class UniformRadii(Parameters):
    """Random radii, uniform between two bounds, as a function of the seed (the RAND of Nesterenko's section 3.5)."""

    low: float = _field(..., "smallest radius", "m", gt=0.0)
    high: float = _field(..., "largest radius", "m", gt=0.0)
    seed: int = _field(0, "seed of the random radii", "1", ge=0, lt=2**63)

    @model_validator(mode="after")
    def _validate_order(self) -> UniformRadii:
        if self.high < self.low:
            raise ParameterError(f"got {self.high:g} m", expected=f"at least low = {self.low:g} m", at="high")
        return self

    def draw_radii(self, grains: int) -> FloatArray:
        """Return the radii, shape (grains,) [m]; the radius of grain i depends only on the seed and on i."""
        return self.low + (self.high - self.low) * uniform(self.seed, 0, grains)


class ChainParameters(Parameters):
    """A row of grains that interact by a contact law (Hertz's unless another is named), with its two ends."""

    grains: int = _field(..., "number of grains", "1", ge=1, le=_MAXIMUM_GRAINS, examples=[4])
    radius: Positive | list[Positive] | UniformRadii = _field(3e-3, "radius: one for all grains, one each, or random", "m")
    material: Preset | Material | list[Preset | Material] = _field(
        "steel", f"material, or the name of a preset ({preset_text()}): one for all grains, or one each", "1"
    )
    mass: Positive | list[Positive] | dict[Annotated[Index, Field(strict=False)], Positive] | None = _field(
        None, "mass in place of density x volume: one for all grains, one each, or {index: mass}", "kg"
    )
    arrangement: ChosenArrangement = _field(
        "uniform", "arrangement of grains: uniform, dimer, tapered, decorated, impurity, or a table {name = ..., ...}", "1"
    )
    contact_stiffness: Positive | list[NotNegative] | None = _field(
        None,
        "k of F = k overlap^p in place of the materials' (p = 1.5: spheres): one for all contacts and walls, or one each",
        "N/m^p",
    )
    law: ChosenLaw = _field(Hertz(), "contact law: its name, or a table of its name and parameters", "1")
    gravity: float = _field(0.0, "acceleration of gravity, positive to the right", "m/s^2", ge=-1e6, le=1e6)
    gap: NotNegative | list[NotNegative] = _field(0.0, "initial gap: one for all contacts, or one for each place", "m")
    precompression: float = _field(0.0, "static compressive force in the chain at the start", "N", ge=0.0, le=1e60)
    left: Boundary = _field("free", "left end: free, piston (the end grain's velocity is prescribed), or a wall", "1")
    right: Boundary = _field("free", "right end: free, piston (the end grain's velocity is prescribed), or a wall", "1")
    left_wall_material: Preset | Material | None = _field(None, "material of the left wall; default: the end grain's", "1")
    right_wall_material: Preset | Material | None = _field(None, "material of the right wall; default: the end grain's", "1")
    integrator: Integrator = _field("pefrl", "integrator: pefrl, leapfrog, rk4 or hamming", "1")
    step_size: Positive | None = _field(None, "internal step; default: computed from stiffness, mass and velocity_scale", "s")
    velocity_scale: float = _field(
        10.0, "largest expected relative speed of neighbours, for the default step", "m/s", ge=1e-9, le=1e9
    )
    overlap_limit: float = _field(0.1, "largest allowed overlap, as a fraction of the smaller radius", "1", gt=0.0)

    @model_validator(mode="before")
    @classmethod
    def _refuse_indices(cls, fields: Any) -> Any:
        """Refuse {index: value} for parameters other than the mass."""
        for name in ("radius", "material", "gap", "contact_stiffness"):
            value = fields.get(name) if isinstance(fields, dict) else None
            if isinstance(value, dict) and any(str(key).lstrip("-").isdigit() for key in value):
                raise ValueError(
                    f"{name}: got {one_line(value)}, expected one value for all or a list with one for each; only mass accepts "
                    "{index: value}" + ("; or arrangement = impurity" if name in ("radius", "material") else "")
                )
        return fields

    @model_validator(mode="after")
    def _validate_shapes(self) -> ChainParameters:
        for name in ("radius", "material", "mass"):
            value = getattr(self, name)
            if isinstance(value, list) and len(value) != self.grains:
                raise ParameterError(
                    f"got {len(value)} values", expected=f"one value for all, or {self.grains}, one for each grain", at=name
                )
        if isinstance(self.mass, dict) and any(index >= self.grains for index in self.mass):
            raise ParameterError(f"got index {max(self.mass)}", expected=f"0 to {self.grains - 1}", at="mass")
        for side, end in (("left", self.left), ("right", self.right)):
            if getattr(self, f"{side}_wall_material") is not None and end not in ("fixed_grain", "plane"):
                raise ParameterError(
                    f"{side} is {end!r}, which has no material",
                    hint=f"give {side} = 'plane' or 'fixed_grain', or leave it out",
                    at=f"{side}_wall_material",
                )
        refuse_incomplete(type(self.law), self.law.name)
        if self.law.needs_stiffness and self.contact_stiffness is None:
            raise ParameterError(
                f"law {self.law.name!r} requires it, in N/m^exponent",
                hint="it follows from radii and materials for spheres only",
                at="contact_stiffness",
            )
        self._validate_contact_lists()
        if "piston" in (self.left, self.right) and self.grains == 1:
            raise ParameterError("got 1", expected="at least 2 if an end is a piston, which must push a grain", at="grains")
        gaps = self.gap if isinstance(self.gap, list) else [self.gap]
        if self.precompression > 0.0 and any(gap > 0.0 for gap in gaps):
            raise ParameterError("a precompressed chain has no gaps", hint="give gap = 0 or precompression = 0", at="gap")
        return self

    def _validate_contact_lists(self) -> None:
        """Check that lists for contacts have a value for each place, and 0 at places without a contact."""
        for holder, name, needed in (
            (self, "contact_stiffness", True), (self, "gap", False),
            *((self.law, name, needed) for name, needed in self.law.place_parameters.items()),
        ):  # fmt: skip
            values = getattr(holder, name, None)
            if not isinstance(values, list):
                continue
            name = name if holder is self else f"law.{name}"
            if len(values) != self.contact_places:
                raise ParameterError(
                    f"got {len(values)} values",
                    expected=(
                        f"one value for all, or {self.contact_places}, one for each place: from left of the first grain to "
                        "right of the last grain, with 0 at places without a contact"
                    ),
                    at=name,
                )
            for place, value in enumerate(values):
                if not self.has_contact(place) and value != 0.0:
                    raise ParameterError(
                        f"got {value:g}", expected=f"0: {self.missing_contact_reason(place)}", at=f"{name}[{place}]"
                    )
                if self.has_contact(place) and needed and value == 0.0:
                    raise ParameterError("got 0", expected="more than 0: this place has a contact", at=f"{name}[{place}]")

    @model_validator(mode="after")
    def _validate_arrangement(self) -> ChainParameters:
        refuse_unfit_arrangement(self)
        return self

    @model_serializer(mode="wrap")
    def _serialize_without_arrangement(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Omit parameters that the arrangement sets, so that the result can be read back, and a uniform arrangement."""
        fields = serialize(self)
        spared = ("arrangement",) if isinstance(self.arrangement, Uniform) else self.arrangement.replaced_parameters()
        return {name: value for name, value in fields.items() if name not in spared}

    @property
    def contact_places(self) -> int:
        """Number of places for contacts, n + 1: place i is left of grain i, place n right of the last grain.

        Ends without a wall also have a place, so that the numbers of places do not depend on the kinds of the ends.
        """
        return self.grains + 1

    def has_contact(self, place: int) -> bool:
        """Return whether a place from 0 to n has a contact: always between neighbours, at an end only with a wall."""
        return 0 < place < self.grains or (self.left if place == 0 else self.right) in WALLS

    def missing_contact_reason(self, place: int) -> str:
        """Return for an error message the reason why the chain has no contact at this end."""
        side = "left" if place == 0 else "right"
        return (
            f"{side} is {getattr(self, side)!r}, so there is no contact {side} of grain {0 if place == 0 else self.grains - 1}"
        )
