"""Parameters of a specimen of movable cellular automata."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ..areas import ChosenArea
from ..boundaries import OPPOSITE
from ..errors import nearest
from ..materials.elastic import Material, Preset, preset_list
from ..support.parameter_fields import Index, Pair, field
from ..support.validation import Parameters
from .boundaries import ChosenBoundary, Periodic, Traction
from .breaking import ChosenCriterion, Unbreakable
from .relinking import ChosenRelinking, Never
from .responses import ChosenResponse, Linear
from .shapes import ChosenShape, Rectangle

__all__ = ["AutomataParameters", "Place"]

Place = Index | Pair


class StrengthRegion(Parameters):
    """A region in which pairs are weaker or stronger."""

    area: ChosenArea = field(..., "pairs whose middle lies in this area: a box or a disc", "1")
    factor: float = field(..., "of their strengths", "1", gt=0.0)


class AutomataParameters(Parameters):
    """A specimen that is packed with equal automata, its material and its four edges; plane strain."""

    shape: ChosenShape = field(
        ...,
        "what is filled: rectangle, disc or polygon; a table {name = ..., ...}",
        "1",
        examples=[{"name": "rectangle", "width": 0.04, "height": 0.0346410161514}],
    )
    diameter: float = field(..., "diameter of the automata", "m", gt=0.0, examples=[0.01])
    packing: Literal["square", "hexagonal"] = field("hexagonal", "square, or hexagonal with rows along x", "1")
    material: Preset | Material = field("steel", f"material, or the name of a preset ({preset_list()})", "1")
    thickness: float = field(1.0, "extent along z", "m", gt=0.0)
    response: ChosenResponse = field(
        Linear(), "response of pairs: linear, degrading, plastic or plastic_degrading; a table {name = ..., ...}", "1"
    )
    criterion: ChosenCriterion = field(
        Unbreakable(),
        "what breaks pairs: none, von_mises, drucker_prager, mohr_coulomb or strain; a table {name = ..., ...}",
        "1",
    )
    strength_scatter: float = field(0.0, "strengths of pairs lie evenly within 1 -+ this", "1", ge=0.0, lt=1.0)
    strength_seed: int = field(0, "which draw of strengths", "1", ge=0, lt=2**63)
    strength_regions: list[StrengthRegion] = field(
        [], "where pairs are weaker or stronger, as a flaw or a seam is; later ones cover earlier ones", "1"
    )
    release_ticks: int = field(20, "over how many internal steps a broken pair is released", "1", ge=1, le=1_000_000)
    friction: float = field(0.5, "coefficient of friction of pairs that touch and are not linked", "1", ge=0.0)
    contact_damping: float = field(
        0.0, "dashpot of pairs that touch and are not linked, along their line of centres, in parts of critical damping", "1",
        ge=0.0, le=1.0,
    )  # fmt: skip
    relinking: ChosenRelinking = field(
        Never(), "what links broken pairs again: none or cold_welding; a table {name = ..., ...}", "1"
    )
    boundaries: dict[str, ChosenBoundary] = field(
        {}, "what left, right, bottom and top do: free (the default), fixed, symmetry, periodic, velocity, traction", "1",
        examples=[{"left": "velocity"}],
    )  # fmt: skip
    forced_automata: list[Place] | Literal["all"] = field(
        [], "automata with a force of their own, the input `force`: numbers, or points [x, y] in the shape; or all", "1"
    )
    step_size: float | None = field(None, "internal step; default 0.7 of the largest stable one, rounded down", "s", gt=0.0)

    @model_validator(mode="after")
    def _validate_edges(self) -> AutomataParameters:
        for name, boundary in self.boundaries.items():
            if name not in OPPOSITE:
                raise ValueError(f"boundaries.{name}: is no edge of a specimen; {nearest(name, OPPOSITE)}")
            if isinstance(boundary, Periodic) and not isinstance(self.boundaries.get(OPPOSITE[name]), Periodic):
                raise ValueError(f"boundaries.{name}: is periodic, so {OPPOSITE[name]} has to be periodic too")
            if isinstance(boundary, (Periodic, Traction)) and not isinstance(self.shape, Rectangle):
                raise ValueError(f"boundaries.{name}: {boundary.name!r} needs a straight edge; expected shape = rectangle")
            if isinstance(boundary, (Periodic, Traction)):
                self._refuse_notch(name, boundary)
        return self

    def _refuse_notch(self, edge: str, boundary: Periodic | Traction) -> None:
        """Refuse a hole in an edge that has to be whole."""
        place = ("left", "right", "bottom", "top").index(edge)
        for number, hole in enumerate(self.shape.holes):
            low, high = hole.bounds[place // 2 * 2 : place // 2 * 2 + 2]
            if low < self.shape.bounds[place] < high:
                raise ValueError(f"boundaries.{edge}: {boundary.name!r} needs a whole edge; shape.holes[{number}] reaches it")

    @model_validator(mode="after")
    def _validate_relinking(self) -> AutomataParameters:
        if self.relinking.kinds and not self.criterion.causes:
            raise ValueError("relinking: links what has broken, and nothing breaks; choose a criterion, or leave relinking out")
        return self

    @property
    def has_history(self) -> bool:
        """Return whether pairs yield or break."""
        return bool(self.criterion.causes) or not self.response.elastic

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Return whether left and right are one, and bottom and top."""
        left, bottom = (isinstance(self.boundaries.get(name), Periodic) for name in ("left", "bottom"))
        return left, bottom
