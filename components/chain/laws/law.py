"""The base of all contact laws: what a law declares, and what a chain asks of it while it is built."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from ...support.float_arrays import FloatArray
from ...support.tagged_union import Named
from ..layout import MOST_HISTORY_ROWS
from . import functions

# A sphere begins to yield, under its surface, at a peak pressure of 1.6 times the yield strength (Johnson 1985, section 6.1).
YIELD_PRESSURE = 1.6


class Law(Named):
    """A contact law, chosen by its `name`: its parameters. Kernels see the law as a tuple of the class `contacts`.

    `functions.py` lists the functions that the file of a law registers for that class.
    """

    contacts: ClassVar[type]
    """The `NamedTuple` of the constants and the history of the contacts."""
    exponent: ClassVar[float]
    """The exponent p with which the force grows with the overlap, F ~ d^p; a law may make a parameter of it."""
    history_rows: ClassVar[int] = 0
    """Numbers in the history of a contact; 0 where the force depends on the present overlap alone."""
    needs_stiffness: ClassVar[bool] = False
    """True where `contact_stiffness` has to be given, because it does not follow from radii and materials."""
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({})
    """The parameters that may be lists with a number for each contact -> whether that has to be above 0."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the constants of each contact in addition to its stiffness, shape (contacts, k) with k up to 3.

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
    """Return the names of the functions and attributes that a law lacks, for runs or for gradients."""
    needed = functions.ELASTIC + (functions.ELASTIC_GRADIENT if gradient else ())
    if issubclass(law, Dissipative):
        needed += functions.DISSIPATIVE + (functions.DISSIPATIVE_GRADIENT if gradient else ())
    if law.history_rows:
        needed += functions.HISTORY
    own = () if hasattr(law, "exponent") or "exponent" in law.model_fields else ("exponent",)
    own += () if law.overlap_at is not Law.overlap_at else ("overlap_at",)
    return own + lacks(law, needed)


def lacks(law: type[Law], needed: tuple[Any, ...]) -> tuple[str, ...]:
    """Return the names of those functions that are not registered for a law."""
    kind = getattr(law, "contacts", None)
    return tuple(function.__name__ for function in needed if kind not in function.implementations)


def refuse_incomplete(law: type[Law], name: str) -> None:
    """Refuse a law that no kernel could run.

    Raises:
        ValueError: names the missing parts.
    """
    missing = missing_parts(law)
    if missing:
        raise ValueError(
            f"law {name!r} lacks {', '.join(missing)} in {law.__module__}; define what `laws/functions.py` and "
            "`laws/law.py` describe, or choose another law"
        )
    if issubclass(law, Dissipative) and law.history_rows:
        raise ValueError(f"law {name!r} has a history and a dissipation; no integrator combines them: expected one of the two")
    if law.history_rows > MOST_HISTORY_ROWS:
        raise ValueError(f"law {name!r} has {law.history_rows} history rows, expected at most {MOST_HISTORY_ROWS}")
