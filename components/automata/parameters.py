"""Parameters of a specimen of movable cellular automata."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ..materials.elastic import Material, Preset, preset_list
from ..support.fields import Index, field
from ..support.validation import Parameters
from .breaking import ChosenCriterion, Unbreakable
from .responses import ChosenResponse, Linear
from .shapes import ChosenShape, Rectangle
from .sides import SIDES, SideKind

__all__ = ["AutomataParameters"]


_SIDE = (
    "free, fixed, symmetry, platen (smooth, moves with {0}_speed), velocity ({0}_velocity), traction ({0}_traction), periodic"
)


class AutomataParameters(Parameters):
    """A specimen that is packed with equal automata, its material and its four sides; plane strain."""

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
    release_ticks: int = field(20, "over how many internal steps a broken pair is released", "1", ge=1, le=1_000_000)
    friction: float = field(0.5, "coefficient of friction of pairs that touch and are not linked", "1", ge=0.0)
    left: SideKind = field("free", f"left side: {_SIDE.format('left')}", "1")
    right: SideKind = field("free", f"right side: {_SIDE.format('right')}", "1")
    bottom: SideKind = field("free", f"lower side: {_SIDE.format('bottom')}", "1")
    top: SideKind = field("free", f"upper side: {_SIDE.format('top')}", "1")
    grip_depth: float = field(0.0, "how far from the outermost automaton a side reaches", "m", ge=0.0)
    loaded: list[Index] | Literal["all"] = field([], "automata that the input `force` acts on: their numbers, or all", "1")
    step_size: float | None = field(None, "internal step; default 0.7 of the largest stable one, rounded down", "s", gt=0.0)

    @model_validator(mode="after")
    def _validate_sides(self) -> AutomataParameters:
        for one, other in (("left", "right"), ("bottom", "top")):
            kinds = getattr(self, one), getattr(self, other)
            if kinds.count("periodic") == 1:
                raise ValueError(f"{one}: got {kinds[0]!r} and {other} = {kinds[1]!r}, expected both or none to be periodic")
        if not isinstance(self.shape, Rectangle):
            for side in SIDES:
                if getattr(self, side) in ("periodic", "traction"):
                    raise ValueError(f"{side}: {getattr(self, side)!r} needs a straight side; expected shape = rectangle")
        return self

    @property
    def has_history(self) -> bool:
        """Return whether pairs yield or break."""
        return bool(self.criterion.causes) or not self.response.elastic

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Return whether left and right are one, and bottom and top."""
        return self.left == "periodic", self.bottom == "periodic"
