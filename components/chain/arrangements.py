"""Arrangements of grains by name: uniform, dimer, tapered, decorated, impurity."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from ..errors import ParameterError
from ..materials.elastic import Material, Preset, to_material
from ..support.elementary_functions import integer_power, nth_root
from ..support.float_arrays import FloatArray
from ..support.parameter_fields import Index, Positive, field
from ..support.tagged_union import ByName, Named

if TYPE_CHECKING:
    from .parameters import ChainParameters

# Range of radii for which a chain accepts the mass of a grain [m].
_TINY, _HUGE = 1e-20, 1e18
_Pair = Field(min_length=2, max_length=2)


class Arrangement(Named):
    """An order of grains, chosen by its `name`: the radius and material of each grain, and the mass of some.

    The chain's own `radius`, `material` and `mass` apply to all properties that the arrangement does not set.
    """

    per_grain: ClassVar[tuple[str, ...]] = ("radius", "material")
    """Fields that set the chain parameters of the same names; a parameter must not be given in both places."""

    def replaced_parameters(self) -> tuple[str, ...]:
        """Return the chain parameters that this arrangement sets."""
        return tuple(name for name in self.per_grain if getattr(self, name, None) is not None)

    def require_grain_count(self, grains: int) -> None:
        """Raise `ParameterError` if a chain with this number of grains cannot have this arrangement."""

    def radii(self, defaults: FloatArray) -> FloatArray:
        """Return the radius of each grain, given the chain's own radii, shape (n,) [m]."""
        return defaults

    def materials(self, defaults: list[Material]) -> list[Material]:
        """Return the material of each grain, given the chain's own materials."""
        chosen = getattr(self, "material", None)
        return defaults if chosen is None else [to_material(chosen)] * len(defaults)

    def masses(self, defaults: FloatArray) -> FloatArray:
        """Return the mass of each grain, given density x volume, shape (n,) [kg]."""
        return defaults


class Uniform(Arrangement):
    """All grains have the chain's own radius, material and mass: one value for all, or one for each."""

    name: Literal["uniform"] = "uniform"


class Dimer(Arrangement):
    """Cells of N1 grains of one kind and N2 of another, from the left; the last cell may be incomplete.

    Source: M. A. Porter, C. Daraio, E. B. Herbold, I. Szelengowicz, P. G. Kevrekidis, Phys. Rev. E 77, 015601 (2008).
    """

    name: Literal["dimer"] = "dimer"
    radius: Positive | Annotated[list[Positive], _Pair] | None = field(
        None, "radii of the two kinds of grain: one for both, or two; default: the chain's radius", "m"
    )
    material: Preset | Material | Annotated[list[Preset | Material], _Pair] | None = field(
        None, "materials of the two kinds of grain: one for both, or two; default: the chain's material", "1"
    )
    counts: Annotated[list[Annotated[int, Field(ge=1, le=1000)]], _Pair] = field(
        [1, 1], "numbers of grains of each kind in a cell", "1"
    )

    @model_validator(mode="after")
    def _validate_kinds(self) -> Dimer:
        # Two equal values may belong to a scan over their ratio; if no pair is given at all, the equal kinds are a mistake.
        if not isinstance(self.radius, list) and not isinstance(self.material, list):
            raise ParameterError("both kinds of grain are the same", hint="give two radii, two materials, or both", at="radius")
        return self

    def require_grain_count(self, grains: int) -> None:  # noqa: D102
        if grains < sum(self.counts):
            raise ParameterError(
                f"got {self.counts}, a cell of {sum(self.counts)} grains, but the chain has {grains}", at="counts"
            )

    def radii(self, defaults: FloatArray) -> FloatArray:  # noqa: D102
        return defaults if self.radius is None else np.broadcast_to(self.radius, (2,))[self._grain_kinds(len(defaults))]

    def materials(self, defaults: list[Material]) -> list[Material]:  # noqa: D102
        if not isinstance(self.material, list):
            return super().materials(defaults)
        pair = [to_material(one) for one in self.material]
        return [pair[kind] for kind in self._grain_kinds(len(defaults))]

    def _grain_kinds(self, grains: int) -> np.ndarray:
        """Return the kind of each grain, 0 or 1, shape (n,)."""
        return (np.arange(grains) % sum(self.counts) >= self.counts[0]).astype(np.intp)


class Tapered(Arrangement):
    """R_(i+1) = (1 - q) R_i, with the taper q or the last radius given. For negative q the grains grow.

    Source: S. Sen, F. S. Manciu, M. Manciu, Physica A 299, 551 (2001), who called it tapered chain.
    """

    name: Literal["tapered"] = "tapered"
    first_radius: Positive = field(..., "radius of the first grain", "m")
    taper: float | None = field(None, "q of R_(i+1) = (1 - q) R_i; alternative to last_radius", "1", gt=-1.0, lt=1.0)
    last_radius: Positive | None = field(None, "radius of the last grain; alternative to taper", "m")
    material: Preset | Material | None = field(None, "material of all grains; default: the chain's material", "1")

    @model_validator(mode="after")
    def _validate_taper(self) -> Tapered:
        if (self.taper is None) == (self.last_radius is None):
            come = "neither" if self.taper is None else "both"
            raise ParameterError(f"got {come} of taper and last_radius", expected="one of them", at="taper")
        return self

    def replaced_parameters(self) -> tuple[str, ...]:  # noqa: D102
        return ("radius", *super().replaced_parameters())

    def require_grain_count(self, grains: int) -> None:  # noqa: D102
        if self.last_radius is not None and grains == 1 and self.last_radius != self.first_radius:
            raise ParameterError(
                "a chain of one grain has only first_radius", hint="expected at least 2 grains", at="last_radius"
            )
        _last_radius(self.first_radius, self._radius_factor(grains), grains)

    def radii(self, defaults: FloatArray) -> FloatArray:  # noqa: D102
        return _geometric_sequence(self.first_radius, self._radius_factor(len(defaults)), len(defaults))

    def _radius_factor(self, grains: int) -> float:
        if self.taper is not None:
            return 1.0 - self.taper
        assert self.last_radius is not None
        return nth_root(self.last_radius / self.first_radius, grains - 1) if grains > 1 else 1.0


class Decorated(Arrangement):
    """Large, small, large, ..., large: an odd number of grains. The large ones may be tapered, the small ones are equal.

    Source: R. L. Doney, S. Sen, Phys. Rev. Lett. 97, 155502 (2006): decorated, tapered chains as impulse absorbers.
    """

    name: Literal["decorated"] = "decorated"
    radius: Positive = field(..., "radius of the large grains, of the first one if they are tapered", "m")
    decoration_radius: Positive = field(..., "radius of the small grains", "m")
    taper: float = field(0.0, "q of R_(i+1) = (1 - q) R_i for successive large grains", "1", gt=-1.0, lt=1.0)
    material: Preset | Material | None = field(None, "material of the large grains; default: the chain's material", "1")
    decoration_material: Preset | Material | None = field(None, "material of the small grains; default: `material`", "1")

    def require_grain_count(self, grains: int) -> None:  # noqa: D102
        if grains < 3 or grains % 2 == 0:
            raise ParameterError(
                f"'decorated' does not fit {grains} grains",
                hint="expected an odd number of at least 3, with a large grain at each end",
                at="name",
            )
        smallest = min(self.radius, _last_radius(self.radius, 1.0 - self.taper, grains // 2 + 1))
        # Small grains may be as large as the smallest large one, up to the rounding error of that radius.
        if smallest * (1.0 + 1e-12) < self.decoration_radius:
            raise ParameterError(
                f"got {self.decoration_radius:g} m",
                expected=f"at most the radius of the smallest large grain, {smallest:g} m",
                at="decoration_radius",
            )

    def radii(self, defaults: FloatArray) -> FloatArray:  # noqa: D102
        radius = np.full(len(defaults), self.decoration_radius)
        radius[::2] = _geometric_sequence(self.radius, 1.0 - self.taper, len(defaults) // 2 + 1)
        return radius

    def materials(self, defaults: list[Material]) -> list[Material]:  # noqa: D102
        large = super().materials(defaults)
        if self.decoration_material is not None:
            large = list(large)
            large[1::2] = [to_material(self.decoration_material)] * (len(defaults) // 2)
        return large


class Impurity(Arrangement):
    """Grains of different radius, material or mass in a chain with its own parameters.

    A light impurity in a precompressed chain has a localised mode above the band. Source: G. Theocharis, M. Kavousanakis,
    P. G. Kevrekidis, C. Daraio, M. A. Porter, I. G. Kevrekidis, Phys. Rev. E 80, 066601 (2009).
    """

    per_grain: ClassVar[tuple[str, ...]] = ()

    name: Literal["impurity"] = "impurity"
    index: Index | list[Index] = field(..., "index of the grain, counted from 0, or a list of indices", "1")
    radius: Positive | None = field(None, "radius of the impurity; default: the chain's radius", "m")
    material: Preset | Material | None = field(None, "material of the impurity; default: the chain's material", "1")
    mass: Positive | None = field(None, "mass of the impurity; default: density x volume", "kg")

    @model_validator(mode="after")
    def _validate_impurity(self) -> Impurity:
        if self.radius is None and self.material is None and self.mass is None:
            raise ParameterError("the impurity equals the other grains", hint="give its radius, material or mass", at="radius")
        if not self.indices or len(set(self.indices)) < len(self.indices):
            raise ParameterError(f"got {self.index}", expected="one or more indices, each of them once", at="index")
        return self

    @property
    def indices(self) -> list[int]:
        """Indices of the grains that are impurities."""
        return self.index if isinstance(self.index, list) else [self.index]

    def require_grain_count(self, grains: int) -> None:  # noqa: D102
        if max(self.indices) >= grains:
            raise ParameterError(
                f"got {max(self.indices)}", expected=f"0 to {grains - 1}: the chain has {grains} grains", at="index"
            )

    def radii(self, defaults: FloatArray) -> FloatArray:  # noqa: D102
        return self._replace_impurities(defaults, self.radius)

    def materials(self, defaults: list[Material]) -> list[Material]:  # noqa: D102
        if self.material is None:
            return defaults
        mixed = list(defaults)
        for index in self.indices:
            mixed[index] = to_material(self.material)
        return mixed

    def masses(self, defaults: FloatArray) -> FloatArray:  # noqa: D102
        return self._replace_impurities(defaults, self.mass)

    def _replace_impurities(self, defaults: FloatArray, value: float | None) -> FloatArray:
        if value is None:
            return defaults
        values = defaults.copy()
        values[self.indices] = value
        return values


ARRANGEMENTS: dict[str, type[Arrangement]] = {
    "uniform": Uniform,
    "dimer": Dimer,
    "tapered": Tapered,
    "decorated": Decorated,
    "impurity": Impurity,
}
ChosenArrangement = Annotated[SerializeAsAny[Arrangement], ByName(ARRANGEMENTS)]


def refuse_unfit_arrangement(parameters: ChainParameters) -> None:
    """Raise `ParameterError` if an arrangement does not fit the chain, or repeats one of the chain's own parameters."""
    arrangement = parameters.arrangement
    try:
        arrangement.require_grain_count(parameters.grains)
    except ParameterError as error:
        raise error.with_outer_location("arrangement") from None
    for name in arrangement.replaced_parameters():
        if name in parameters.model_fields_set:
            raise ParameterError(
                "the arrangement sets it too", hint=f"set it in one place, as {name} or in the arrangement", at=name
            )
    if isinstance(arrangement, Impurity) and arrangement.mass is not None and parameters.mass is not None:
        if not isinstance(parameters.mass, dict) or any(index in parameters.mass for index in arrangement.indices):
            raise ParameterError("the arrangement 'impurity' sets this mass too", hint="set it in one place", at="mass")


def _geometric_sequence(first: float, factor: float, count: int) -> FloatArray:
    """Return first, first x factor, ... by repeated multiplication, shape (count,)."""
    terms = np.full(count, factor)
    terms[0] = first
    with np.errstate(over="ignore", under="ignore"):
        return np.multiply.accumulate(terms)


def _last_radius(first: float, factor: float, count: int) -> float:
    """Return the last term of `_geometric_sequence`, approximately; `ParameterError` if a term is too small or too large."""
    last = first * integer_power(factor, count - 1)
    if not _TINY <= first <= _HUGE and 1e-100 <= last <= 1e100:
        return last  # reported by the check of the masses
    bound = _TINY if factor < 1.0 else _HUGE
    if not _TINY <= last <= _HUGE:
        where = math.ceil(math.log(bound / first) / math.log(factor)) if _TINY <= first <= _HUGE else 0
        left = "too small" if factor < 1.0 else "too large"
        raise ParameterError(
            f"from grain {where} on, the radii are {left}", hint="take fewer grains or a smaller taper", at="taper"
        )
    return last
