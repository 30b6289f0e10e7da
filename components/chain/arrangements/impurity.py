"""A few grains that are unlike the others."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import model_validator

from ...errors import ParameterError
from ...materials.elastic import Material, Preset, material
from ...support.parameter_fields import Index, Positive, field
from .arrangement import Arrangement, FloatArray


class Impurity(Arrangement):
    """Grains of other radius, material or mass among those that the chain's own parameters describe.

    A light impurity in a pressed chain carries a localised mode above the band. Source: G. Theocharis, M. Kavousanakis,
    P. G. Kevrekidis, C. Daraio, M. A. Porter, I. G. Kevrekidis, Phys. Rev. E 80, 066601 (2009).
    """

    per_grain: ClassVar[tuple[str, ...]] = ()

    name: Literal["impurity"] = "impurity"
    index: Index | list[Index] = field(..., "which grain, counted from 0, or a list of them", "1")
    radius: Positive | None = field(None, "of the impurity; default: as its neighbours'", "m")
    material: Preset | Material | None = field(None, "of the impurity; default: as its neighbours'", "1")
    mass: Positive | None = field(None, "of the impurity; default: density x volume", "kg")

    @model_validator(mode="after")
    def _unlike(self) -> Impurity:
        if self.radius is None and self.material is None and self.mass is None:
            raise ParameterError("the impurity is like the other grains", hint="give its radius, material or mass", at="radius")
        if not self.indices or len(set(self.indices)) < len(self.indices):
            raise ParameterError(f"got {self.index}", expected="one grain or more, each of them once", at="index")
        return self

    @property
    def indices(self) -> list[int]:
        """The impurities."""
        return self.index if isinstance(self.index, list) else [self.index]

    def fit(self, grains: int) -> None:  # noqa: D102
        if max(self.indices) >= grains:
            raise ParameterError(
                f"got {max(self.indices)}", expected=f"0 to {grains - 1}: the chain has {grains} grains", at="index"
            )

    def radii(self, host: FloatArray) -> FloatArray:  # noqa: D102
        return host if self.radius is None else self._place(host, self.radius)

    def materials(self, host: list[Material]) -> list[Material]:  # noqa: D102
        if self.material is None:
            return host
        mixed = list(host)
        for index in self.indices:
            mixed[index] = material(self.material)
        return mixed

    def masses(self, host: FloatArray) -> FloatArray:  # noqa: D102
        return host if self.mass is None else self._place(host, self.mass)

    def _place(self, host: FloatArray, value: float) -> FloatArray:
        values = host.copy()
        values[self.indices] = value
        return values
