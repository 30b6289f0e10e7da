"""The base of all contact laws: what a law declares, and what a chain asks of it while it is built."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType, ModuleType
from typing import Any, ClassVar

import numpy as np

from ...support.float_arrays import FloatArray
from ...support.tagged_union import Named
from ..layout import MOST_HISTORY_ROWS
from . import placeholders

# A sphere begins to yield, under its surface, at a peak pressure of 1.6 times the yield strength (Johnson 1985, section 6.1).
YIELD_PRESSURE = 1.6


class Law(Named):
    """A contact law, chosen by its `name`: its parameters here, its formulas as jitted functions in the same file.

    Which functions a law's file has to define, and with which arguments, says `placeholders.py`.
    """

    exponent: ClassVar[float]
    """The exponent p with which the force grows with the overlap, F ~ d^p; a law may make a parameter of it."""
    history_rows: ClassVar[int] = 0
    """Count of the numbers that tell what a contact has been through; 0 where the force does not depend on it."""
    needs_stiffness: ClassVar[bool] = False
    """True where `contact_stiffness` has to be given, because radii and materials do not tell it."""
    long_formula: ClassVar[bool] = False
    """True where the force is so long a formula that loops become vectors only where all forces are computed first."""
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({})
    """The parameters that may be lists with a number for each contact -> whether that has to be above 0."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return what the law wants to know of each contact beside its stiffness, shape (contacts, k) with k up to 3.

        Args:
            stiffness: of each place, shape (n + 1,), as the other arrays.
            reduced_radius: R* [m].
            yield_strength: of the weaker side [Pa].
            contacts: which places are contacts.
        """
        return np.zeros((contacts.stop - contacts.start, 0))

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return the overlap at which a contact that was never loaded before carries a force, shape (contacts,) [m].

        Every law has its own: a chain that is pressed, or a column that carries its weight, begins with it.
        """
        raise NotImplementedError

    def steepest(self, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return the k of F = k d^p where contacts are stiffest, which the step has to resolve, shape (contacts,).

        The default step and the caution about its length rest on this k. A law whose force grows faster than
        `contact_stiffness` d^p has to return a larger one.
        """
        return stiffness

    def yield_pressures(self, stiffness: FloatArray, reduced_radius: FloatArray, constants: FloatArray) -> FloatArray | None:
        """Return the pressures at which contacts yield by this law, shape (contacts,) [Pa]; None where it knows none."""
        return None

    @property
    def has_history(self) -> bool:
        """Return whether the force depends on what the contact has been through."""
        return self.history_rows > 0

    @property
    def conservative(self) -> bool:
        """Return whether it gives back all energy."""
        return not isinstance(self, Dissipative) and not self.has_history


class Dissipative(Law, ABC):
    """A law whose force depends on the speed of approach, by a coefficient for each contact."""

    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({"dissipation": False})
    dissipation: Any
    jumps: ClassVar[bool] = False
    """True where the force jumps when a contact closes."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the dissipation, the first constant of every law that has one."""
        return (np.zeros(len(stiffness)) + np.asarray(self.dissipation))[contacts, None]

    @abstractmethod
    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return the force per speed of approach at an overlap, shape (contacts,) [N s/m]."""

    @abstractmethod
    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return the overlap beyond which force per speed is above `coefficients`; 0: at once, inf: never; (contacts,) [m]."""


def missing_parts(law: type[Law], *, gradient: bool = False) -> tuple[str, ...]:
    """Return what a law's class and file lack, for runs or for gradients."""
    needed = placeholders.ELASTIC + (placeholders.ELASTIC_GRADIENT if gradient else ())
    if issubclass(law, Dissipative):
        needed += placeholders.DISSIPATIVE + (placeholders.DISSIPATIVE_GRADIENT if gradient else ())
    if law.history_rows:
        needed += placeholders.HISTORY
    own = () if hasattr(law, "exponent") or "exponent" in law.model_fields else ("exponent",)
    own += () if law.overlap_at is not Law.overlap_at else ("overlap_at",)
    return own + lacks(law, needed)


def lacks(law: type[Law], names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of the functions that a law's file does not define."""
    return tuple(name for name in names if not callable(getattr(sys.modules[law.__module__], name, None)))


def refuse_incomplete(law: type[Law], name: str) -> None:
    """Refuse a law that no loop could run.

    Raises:
        ValueError: names what it lacks.
    """
    missing = missing_parts(law)
    if missing:
        raise ValueError(
            f"law {name!r} lacks {', '.join(missing)} in {law.__module__}; define what `laws/placeholders.py` and "
            "`laws/law.py` describe, or choose another law"
        )
    if issubclass(law, Dissipative) and law.history_rows:
        raise ValueError(f"law {name!r} has a history and a dissipation; no integrator combines them: expected one of the two")
    if law.history_rows > MOST_HISTORY_ROWS:
        raise ValueError(f"law {name!r} has {law.history_rows} history rows, expected at most {MOST_HISTORY_ROWS}")


@cache
def law_functions(law: Any) -> ModuleType:
    """Return a law's functions and properties under the names of `placeholders.py`, for the loops."""
    own = sys.modules[law.__module__]
    space = ModuleType(own.__name__)
    for name in (
        placeholders.ELASTIC
        + placeholders.ELASTIC_GRADIENT
        + placeholders.DISSIPATIVE
        + placeholders.DISSIPATIVE_GRADIENT
        + (placeholders.HISTORY + placeholders.ENERGY_ROOT)
    ):
        if hasattr(own, name):
            setattr(space, name, getattr(own, name))
    vars(space).update(
        DISSIPATES=issubclass(law, Dissipative),
        JUMPS=issubclass(law, Dissipative) and law.jumps,
        REMEMBERS=law.history_rows > 0,
        LONG_FORMULA=law.long_formula,
    )
    return space
