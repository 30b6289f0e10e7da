"""Grains that shrink, or grow, from left to right by a constant factor."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic import model_validator

from ...errors import ParameterError
from ...materials.elastic import Material, Preset
from ...support.elementary_functions import integer_power, nth_root
from ...support.parameter_fields import Positive, field
from .arrangement import Arrangement, FloatArray, alternatives

# Outside of this range a grain has no mass that a chain takes [m].
_TINY, _HUGE = 1e-20, 1e18


class Tapered(Arrangement):
    """R_(i+1) = (1 - q) R_i, with the taper q given, or the last radius. Negative q: the grains grow.

    Source: S. Sen, F. S. Manciu, M. Manciu, Physica A 299, 551 (2001), who called it tapered chain.
    """

    name: Literal["tapered"] = "tapered"
    first_radius: Positive = field(..., "of the first grain", "m")
    taper: float | None = field(None, "q of R_(i+1) = (1 - q) R_i; or give last_radius", "1", gt=-1.0, lt=1.0)
    last_radius: Positive | None = field(None, "of the last grain; or give taper", "m")
    material: Preset | Material | None = field(None, "of all grains; default: the chain's", "1")

    @model_validator(mode="after")
    def _one_way(self) -> Tapered:
        if (self.taper is None) == (self.last_radius is None):
            come = "neither" if self.taper is None else "both"
            raise ParameterError(f"got {come} of taper and last_radius", expected="one of them", at="taper")
        return self

    def own_parameters(self) -> tuple[str, ...]:  # noqa: D102
        return ("radius", *super().own_parameters())

    def fit(self, grains: int) -> None:  # noqa: D102
        if self.last_radius is not None and grains == 1 and self.last_radius != self.first_radius:
            raise ParameterError(
                "the chain has one grain, which is the first", hint="expected at least 2 grains", at="last_radius"
            )
        sound_radii(self.first_radius, self._factor(grains), grains)

    def radii(self, host: FloatArray) -> FloatArray:  # noqa: D102
        return geometric(self.first_radius, self._factor(len(host)), len(host))

    def materials(self, host: list[Material]) -> list[Material]:  # noqa: D102
        return host if self.material is None else alternatives(self.material, len(host))

    def _factor(self, grains: int) -> float:
        if self.taper is not None:
            return 1.0 - self.taper
        assert self.last_radius is not None
        return nth_root(self.last_radius / self.first_radius, grains - 1) if grains > 1 else 1.0


def geometric(first: float, factor: float, count: int) -> FloatArray:
    """First, first x factor, ... by one multiplication after the other, shape (count,)."""
    terms = np.full(count, factor)
    terms[0] = first
    with np.errstate(over="ignore", under="ignore"):
        return np.multiply.accumulate(terms)


def sound_radii(first: float, factor: float, count: int) -> float:
    """Return the last of these terms, roughly; `ValueError` where they leave the range of a float, or vanish."""
    last = first * integer_power(factor, count - 1)
    if not _TINY <= first <= _HUGE and 1e-100 <= last <= 1e100:
        return last  # not the taper's fault: the check of the masses tells
    bound = _TINY if factor < 1.0 else _HUGE
    if not _TINY <= last <= _HUGE:
        where = math.ceil(math.log(bound / first) / math.log(factor)) if _TINY <= first <= _HUGE else 0
        left = "larger than 0" if factor < 1.0 else "of a finite size"
        raise ParameterError(
            f"from number {where} on no grain is {left}", hint="take fewer grains or a smaller taper", at="taper"
        )
    return last
