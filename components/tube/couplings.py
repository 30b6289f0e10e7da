"""Couplings, by name: the gas feels nothing of the wall (one_way), or that it moves and opens (two_way)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import SerializeAsAny

from ..support.parameter_fields import field
from ..support.tagged_union import ByName, Named


class Coupling(Named):
    """A coupling, chosen by its `name`."""

    @property
    def moves_gas(self) -> bool:
        """True where the gas has the cross-section of the wall as it is, and pays for the work on it."""
        return False

    @property
    def leaks(self) -> bool:
        """True where gas leaves through open cracks."""
        return False


class OneWay(Coupling):
    """The gas flows as in a rigid tube, and its pressure loads the wall: Gato & Shie (2010)."""

    name: Literal["one_way"] = field("one_way", "the gas flows as in a rigid tube", "1")


class TwoWay(Coupling):
    """The gas flows through the cross-section that the wall leaves it, and does work on it."""

    name: Literal["two_way"] = field("two_way", "the gas feels the wall", "1")
    motion: bool = field(True, "whether the gas feels that the wall moves", "1")
    leakage: bool = field(True, "whether gas leaves through open cracks", "1")

    @property
    def moves_gas(self) -> bool:
        """True where the gas has the cross-section of the wall as it is, and pays for the work on it."""
        return self.motion

    @property
    def leaks(self) -> bool:
        """True where gas leaves through open cracks."""
        return self.leakage


COUPLINGS: dict[str, type[Coupling]] = {"one_way": OneWay, "two_way": TwoWay}
ChosenCoupling = Annotated[SerializeAsAny[Coupling], ByName(COUPLINGS)]
