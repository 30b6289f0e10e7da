"""Parameters of a specimen of movable cellular automata."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import SerializeAsAny, model_validator

from .. import boundaries
from ..boundaries import OPPOSITE, Boundary, Free, Periodic, Symmetry, Traction
from ..errors import Location, ParameterError, spelling_hint
from ..materials.elastic import Material, Preset, material_constants, preset_text
from ..regions import ChosenArea
from ..support.parameter_fields import (
    Index,
    Magnitude,
    NotNegativeMagnitude,
    Pair,
    field,
    refuse_extreme_coordinates,
    refuse_extreme_values,
)
from ..support.tagged_union import ByName
from ..support.validation import Parameters
from .laws import ChosenCriteria, ChosenCriterion, Criterion, Unbreakable
from .laws.responses import ChosenResponses, Linear, Response
from .relinking import ChosenRelinking, NoRelinking
from .shapes import ChosenShape, Rectangle

__all__ = ["BOUNDARIES", "AutomataParameters", "Place"]

Place = Index | Pair


class Fixed(boundaries.Fixed):
    """Automata that neither move nor rotate."""

    depth: float = field(0.0, "depth of the edge behind its outermost automaton", "m", ge=0.0)


class PrescribedVelocity(boundaries.PrescribedVelocity):
    """Automata move at the velocity of the input `<edge>_velocity`.

    A plate that prescribes only the component across its edge is smooth: automata slide along it and do not rotate, as on a
    plane of symmetry. If only the component along the edge is prescribed, automata rotate freely.
    """

    depth: float = field(0.0, "depth of the edge behind its outermost automaton", "m", ge=0.0)


BOUNDARIES: dict[str, type[Boundary]] = {
    "free": Free,
    "fixed": Fixed,
    "symmetry": Symmetry,
    "periodic": Periodic,
    "velocity": PrescribedVelocity,
    "traction": Traction,
}

ChosenBoundary = Annotated[SerializeAsAny[Boundary], ByName(BOUNDARIES)]


class StrengthRegion(Parameters):
    """A region in which links are weaker or stronger by a factor."""

    area: ChosenArea = field(..., "area that contains the midpoints of these pairs: a box or a disc", "1")
    factor: Magnitude = field(..., "factor of the strengths of these pairs", "1")


class Region(Parameters):
    """A part of the specimen with one of the materials."""

    area: ChosenArea = field(..., "area that contains the centres of these automata: a box or a disc", "1")
    material: int = field(..., "number of the material, from 0", "1", ge=0)


class Interface(Parameters):
    """The strength of links between automata of two materials."""

    materials: list[Index] = field(..., "numbers of the two materials", "1", min_length=2, max_length=2)
    criterion: ChosenCriterion = field(..., "breaking criterion of their links, of the same name as `criterion`, or none", "1")


class AutomataParameters(Parameters):
    """A specimen packed with equal automata, its materials and its four edges; plane strain."""

    shape: ChosenShape = field(
        ...,
        "shape that the automata fill: rectangle, disc or polygon; a table {name = ..., ...}",
        "1",
        examples=[{"name": "rectangle", "width": 0.04, "height": 0.0346410161514}],
    )
    diameter: float = field(..., "diameter of the automata", "m", gt=0.0, examples=[0.01])
    packing: Literal["square", "hexagonal"] = field("hexagonal", "square, or hexagonal with rows along x", "1")
    material: Preset | Material | list[Preset | Material] = field(
        "steel", f"material, or the name of a preset ({preset_text()}); a list for `regions` or `automaton_material`", "1"
    )
    regions: list[Region] = field([], "areas of the materials; later ones cover earlier ones, material 0 fills the rest", "1")
    automaton_material: list[Index] | None = field(
        None, "number of the material of each automaton, instead of `regions`", "1", absent="none"
    )
    thickness: float = field(1.0, "extent along z", "m", gt=0.0)
    response: ChosenResponses = field(
        Linear(),
        "response of pairs: linear, degrading, plastic or plastic_degrading; a table {name = ..., ...}; one for all materials, "
        "or a list with one for each. Pairs of two materials are linear",
        "1",
    )
    criterion: ChosenCriteria = field(
        Unbreakable(),
        "breaking criterion of pairs: none, von_mises, drucker_prager, mohr_coulomb or strain; a table {name = ..., ...}; one "
        "for all materials, or a list with one for each (of the same name, or none)",
        "1",
    )
    interfaces: list[Interface] = field(
        [],
        "strengths of pairs of two materials; by default such a pair breaks as soon as the criterion of either is met",
        "1",
    )
    strength_scatter: float = field(0.0, "half-width of the random strength factors around 1", "1", ge=0.0, lt=1.0)
    strength_seed: int = field(0, "seed of the random strengths", "1", ge=0, lt=2**63)
    strength_regions: list[StrengthRegion] = field(
        [], "areas of weaker or stronger pairs, e.g. a flaw or a seam; later ones cover earlier ones", "1"
    )
    release_ticks: int = field(20, "number of internal steps in which a broken pair is released", "1", ge=1, le=1_000_000)
    friction: NotNegativeMagnitude = field(0.5, "friction coefficient of contacts (unlinked pairs that touch)", "1")
    contact_damping: float = field(
        0.0, "damping ratio of contacts along their line of centres, as a fraction of critical damping", "1",
        ge=0.0, le=1.0,
    )  # fmt: skip
    relinking: ChosenRelinking = field(
        NoRelinking(), "condition that links broken pairs again: none or cold_welding; a table {name = ..., ...}", "1"
    )
    boundaries: dict[str, ChosenBoundary] = field(
        {}, "conditions of left, right, bottom, top: free (the default), fixed, symmetry, periodic, velocity, traction", "1",
        examples=[{"left": "velocity"}],
    )  # fmt: skip
    forced_automata: list[Place] | Literal["all"] = field(
        [], "automata on which the input `force` acts: numbers, or points [x, y] in the shape; or all", "1"
    )
    step_size: float | None = field(None, "internal step; default: 0.7 of the largest stable step, rounded down", "s", gt=0.0)

    @model_validator(mode="after")
    def _validate_magnitudes(self) -> AutomataParameters:
        refuse_extreme_values(
            [(("diameter",), self.diameter), (("thickness",), self.thickness), *material_constants(self.material)]
        )
        refuse_extreme_coordinates((("shape",), one) for one in self.shape.bounds)
        return self

    @model_validator(mode="after")
    def _validate_edges(self) -> AutomataParameters:
        for name, boundary in self.boundaries.items():
            if name not in OPPOSITE:
                raise ParameterError("is not an edge of the body", hint=spelling_hint(name, OPPOSITE), at=("boundaries", name))
            if isinstance(boundary, Periodic) and not isinstance(self.boundaries.get(OPPOSITE[name]), Periodic):
                raise ParameterError(f"is periodic, so {OPPOSITE[name]} has to be periodic too", at=("boundaries", name))
            if isinstance(boundary, (Periodic, Traction)) and not isinstance(self.shape, Rectangle):
                raise ParameterError(
                    f"{boundary.name!r} needs a straight edge", expected="shape = rectangle", at=("boundaries", name)
                )
            if isinstance(boundary, (Periodic, Traction)):
                self._refuse_notch(name, boundary)
        return self

    def _refuse_notch(self, edge: str, boundary: Periodic | Traction) -> None:
        """Refuse a hole that cuts an edge whose condition requires a whole edge."""
        place = ("left", "right", "bottom", "top").index(edge)
        for number, hole in enumerate(self.shape.holes):
            low, high = hole.bounds[place // 2 * 2 : place // 2 * 2 + 2]
            if low < self.shape.bounds[place] < high:
                raise ParameterError(
                    f"{boundary.name!r} needs a whole edge", hint=f"shape.holes[{number}] reaches it", at=("boundaries", edge)
                )

    @model_validator(mode="after")
    def _validate_relinking(self) -> AutomataParameters:
        if self.relinking.kinds and not self.breakable:
            raise ParameterError("requires pairs that can break; choose a criterion, or leave relinking out", at="relinking")
        if self.relinking.kinds and self.has_several_materials:
            raise ParameterError(
                "does not support pairs of two materials", hint="give one material, or leave relinking out", at="relinking"
            )
        return self

    @model_validator(mode="after")
    def _validate_materials(self) -> AutomataParameters:
        count = len(self.materials)
        if not count:
            raise ParameterError("got none", expected="at least one", at="material")
        for name, given in (("response", self.response), ("criterion", self.criterion)):
            if isinstance(given, list) and len(given) != count:
                raise ParameterError(
                    f"got {len(given)} for {count} materials", hint="give one for all, or one for each", at=(name,)
                )
        if self.regions and self.automaton_material is not None:
            raise ParameterError("`regions` is given too", hint="give only one of them", at="automaton_material")
        for place, region in enumerate(self.regions):
            _refuse_unknown_material(("regions", place, "material"), region.material, count)
        for place, number in enumerate(self.automaton_material or ()):
            _refuse_unknown_material(("automaton_material", place), number, count)
        return self

    @model_validator(mode="after")
    def _validate_interfaces(self) -> AutomataParameters:
        for place, interface in enumerate(self.interfaces):
            for end, number in enumerate(interface.materials):
                _refuse_unknown_material(("interfaces", place, "materials", end), number, len(self.materials))
            if interface.materials[0] == interface.materials[1]:
                raise ParameterError(
                    f"got {interface.materials}", expected="two different materials", at=("interfaces", place, "materials")
                )
        leading = self.leading_criterion
        places: list[Location] = [("criterion", place) for place in range(len(self.criteria))]
        places += [("interfaces", place, "criterion") for place in range(len(self.interfaces))]
        for place, one in zip(places, self._all_criteria(), strict=True):
            if one.causes and one.name != leading.name:
                raise ParameterError(
                    f"got {one.name!r} in addition to {leading.name!r}",
                    expected="criteria of the same name, or none, in a specimen",
                    at=place,
                )
        return self

    def _all_criteria(self) -> list[Criterion]:
        return [*self.criteria, *(one.criterion for one in self.interfaces)]

    @property
    def materials(self) -> list[str | Material]:
        """The materials by number, each the name of a preset or a material."""
        return self.material if isinstance(self.material, list) else [self.material]

    @property
    def has_several_materials(self) -> bool:
        """Return whether there is more than one material."""
        return len(self.materials) > 1

    @property
    def responses(self) -> list[Response]:
        """The response of each material."""
        return self.response if isinstance(self.response, list) else [self.response] * len(self.materials)

    @property
    def criteria(self) -> list[Criterion]:
        """The criterion of each material."""
        return self.criterion if isinstance(self.criterion, list) else [self.criterion] * len(self.materials)

    @property
    def leading_criterion(self) -> Criterion:
        """The first criterion that can break links; all others must be of its kind."""
        return next((one for one in self._all_criteria() if one.causes), Unbreakable())

    @property
    def breakable(self) -> bool:
        """Return whether any pair can break."""
        return bool(self.leading_criterion.causes)

    @property
    def can_yield(self) -> bool:
        """Return whether any pair can yield."""
        return not all(one.elastic for one in self.responses)

    @property
    def has_history(self) -> bool:
        """Return whether any pair can yield or break."""
        return self.breakable or self.can_yield

    @property
    def has_individual_links(self) -> bool:
        """Return whether links are computed one by one: they can yield or break, or there are several materials."""
        return self.has_history or self.has_several_materials

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Return whether the left and right edges are joined, and the bottom and top ones."""
        left, bottom = (isinstance(self.boundaries.get(name), Periodic) for name in ("left", "bottom"))
        return left, bottom


def _refuse_unknown_material(place: Location, number: int, count: int) -> None:
    """Refuse a material number that does not exist."""
    if number >= count:
        raise ParameterError(f"got {number}", expected=f"0 to {count - 1}", at=place)
