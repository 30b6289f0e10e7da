"""Two kinds of grains in turn."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from ...errors import ParameterError
from ...materials.elastic import Material, Preset
from ...support.parameter_fields import Positive, field
from .arrangement import Arrangement, FloatArray, alternatives

_Pair = Field(min_length=2, max_length=2)


class Dimer(Arrangement):
    """Cells of N1 grains of one kind and N2 of another, from the left; the last cell may be cut off.

    Source: M. A. Porter, C. Daraio, E. B. Herbold, I. Szelengowicz, P. G. Kevrekidis, Phys. Rev. E 77, 015601 (2008).
    """

    name: Literal["dimer"] = "dimer"
    radius: Positive | Annotated[list[Positive], _Pair] | None = field(
        None, "of both kinds: one for both, or two; default: the chain's", "m"
    )
    material: Preset | Material | Annotated[list[Preset | Material], _Pair] | None = field(
        None, "of both kinds: one for both, or two; default: the chain's", "1"
    )
    counts: Annotated[list[Annotated[int, Field(ge=1, le=1000)]], _Pair] = field(
        [1, 1], "how many grains of each kind a cell has", "1"
    )

    @model_validator(mode="after")
    def _two_kinds(self) -> Dimer:
        # Two equal values are the end of a scan of ratios; no two values are a slip.
        if not isinstance(self.radius, list) and not isinstance(self.material, list):
            raise ParameterError("both kinds of grain are the same", hint="give two radii, two materials, or both", at="radius")
        return self

    @property
    def period(self) -> int:
        """Grains in a cell."""
        return sum(self.counts)

    def fit(self, grains: int) -> None:  # noqa: D102
        if grains < self.period:
            raise ParameterError(
                f"got {self.counts}, a cell of {self.period} grains, and the chain has {grains} grains", at="counts"
            )

    def radii(self, host: FloatArray) -> FloatArray:  # noqa: D102
        return host if self.radius is None else np.broadcast_to(self.radius, (2,))[self._kinds(len(host))]

    def materials(self, host: list[Material]) -> list[Material]:  # noqa: D102
        if self.material is None:
            return host
        pair = alternatives(self.material, 2)
        return [pair[kind] for kind in self._kinds(len(host))]

    def _kinds(self, grains: int) -> np.ndarray:
        """Return the kind of each grain, 0 or 1, shape (n,)."""
        return (np.arange(grains) % self.period >= self.counts[0]).astype(np.intp)
