"""The base of all arrangements of grains."""

from __future__ import annotations

from typing import ClassVar, Literal

from ...materials.elastic import Material, Preset, material
from ...support.float_arrays import FloatArray
from ...support.tagged_union import Named


class Arrangement(Named):
    """An order of grains: it gives each grain its radius and material, and may give some of them a mass.

    What it leaves alone comes from the chain's own `radius`, `material` and `mass`. Each has a `name`, by which it is chosen.
    """

    per_grain: ClassVar[tuple[str, ...]] = ("radius", "material")
    """Fields that are the chain's parameters of the same name for every grain: given here, they are not given there."""

    def own_parameters(self) -> tuple[str, ...]:
        """Return the chain's parameters that are settled here."""
        return tuple(name for name in self.per_grain if getattr(self, name, None) is not None)

    def fit(self, grains: int) -> None:
        """`ValueError` where no chain of so many grains is arranged like this."""

    def radii(self, host: FloatArray) -> FloatArray:
        """Radius of each grain, from those that the chain's own parameters give, shape (n,) [m]."""
        return host

    def materials(self, host: list[Material]) -> list[Material]:
        """Material of each grain, from those that the chain's own parameters give."""
        return host

    def masses(self, host: FloatArray) -> FloatArray:
        """Mass of each grain, from density x volume, shape (n,) [kg]."""
        return host


class Uniform(Arrangement):
    """All grains as the chain's own radius, material and mass say: equal, or each by hand."""

    name: Literal["uniform"] = "uniform"


def alternatives(given: Preset | Material | list[Preset | Material], kinds: int) -> list[Material]:
    """One material for each kind of grain."""
    return [material(one) for one in given] if isinstance(given, list) else [material(given)] * kinds
