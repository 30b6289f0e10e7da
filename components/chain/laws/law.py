"""The base class of contact laws: declarations, and methods that the construction of a chain calls."""

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

# A sphere begins to yield below its surface at a peak pressure of 1.6 times the yield strength (Johnson 1985, section 6.1).
YIELD_PRESSURE = 1.6


class Law(Named):
    """A contact law with its parameters, chosen by its `name`. In kernels the law is a tuple of the class `contacts`.

    `functions.py` lists the functions that the module of a law registers for this class.
    """

    contacts: ClassVar[type]
    """The `NamedTuple` of the constants and the history of the contacts."""
    exponent: ClassVar[float]
    """The exponent p of the growth of the force with the overlap, F ~ d^p; a law may make it a parameter."""
    history_rows: ClassVar[int] = 0
    """Number of history values per contact; 0 if the force depends only on the present overlap."""
    needs_stiffness: ClassVar[bool] = False
    """True if `contact_stiffness` must be given, because it does not follow from radii and materials."""
    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({})
    """Parameters that may be lists with one number per contact -> whether the numbers must be positive."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the constants of each contact in addition to its stiffness, shape (contacts, k) with k up to 3.

        Args:
            stiffness: contact stiffness at each place, shape (n + 1,), like the other arrays.
            reduced_radius: reduced radius R* [m].
            yield_strength: yield strength of the weaker side [Pa].
            contacts: slice of the places with a contact.
        """
        return np.zeros((contacts.stop - contacts.start, 0))

    def static_overlap(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return the overlap at which a contact without previous load carries a force, shape (contacts,) [m].

        Every law must define it: precompressed chains, and columns under their own weight, start with it.
        """
        raise NotImplementedError

    def largest_stiffness(self, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """Return the largest k of F = k d^p, which the step has to resolve, shape (contacts,).

        The default step and the caution about its length use this k. A law whose force grows faster than `contact_stiffness`
        d^p must return a larger value.
        """
        return stiffness

    def yield_pressures(self, stiffness: FloatArray, reduced_radius: FloatArray, constants: FloatArray) -> FloatArray | None:
        """Return the pressures at which contacts yield by this law, shape (contacts,) [Pa], or None for a law without yield."""
        return None

    @property
    def has_history(self) -> bool:
        """Return whether the force depends on the history of the contact."""
        return self.history_rows > 0

    @property
    def conservative(self) -> bool:
        """Return whether the law conserves energy."""
        return not isinstance(self, Dissipative) and not self.has_history


class Dissipative(Law, ABC):
    """A law whose force depends on the approach speed, with one coefficient per contact."""

    place_parameters: ClassVar[Mapping[str, bool]] = MappingProxyType({"dissipation": False})
    dissipation: Any
    has_force_jump: ClassVar[bool] = False
    """True if the force jumps when a contact closes."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, contacts: slice
    ) -> FloatArray:
        """Return the dissipation, the first constant of every dissipative law."""
        return (np.zeros(len(stiffness)) + np.asarray(self.dissipation))[contacts, None]

    @abstractmethod
    def damping_coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Return the force per approach speed at an overlap, shape (contacts,) [N s/m]."""

    @abstractmethod
    def overlap_from_coefficient(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return the overlap above which damping exceeds `coefficients`, 0 (always) or inf (never), shape (contacts,) [m]."""


def missing_members(law: type[Law], *, gradient: bool = False) -> tuple[str, ...]:
    """Return the names of the functions and attributes that a law lacks, for runs or for gradients."""
    needed = functions.ELASTIC + (functions.ELASTIC_GRADIENT if gradient else ())
    if issubclass(law, Dissipative):
        needed += functions.DISSIPATIVE + (functions.DISSIPATIVE_GRADIENT if gradient else ())
    if law.history_rows:
        needed += functions.HISTORY
    own = () if hasattr(law, "exponent") or "exponent" in law.model_fields else ("exponent",)
    own += () if law.static_overlap is not Law.static_overlap else ("static_overlap",)
    return own + missing_functions(law, needed)


def missing_functions(law: type[Law], needed: tuple[Any, ...]) -> tuple[str, ...]:
    """Return the names of required functions that are not registered for a law."""
    kind = getattr(law, "contacts", None)
    return tuple(function.__name__ for function in needed if kind not in function.implementations)


def refuse_incomplete(law: type[Law], name: str) -> None:
    """Refuse a law that kernels cannot run.

    Raises:
        ValueError: names the missing parts.
    """
    missing = missing_members(law)
    if missing:
        raise ValueError(
            f"law {name!r} lacks {', '.join(missing)} in {law.__module__}; define the members that `laws/functions.py` and "
            "`laws/law.py` list, or choose another law"
        )
    if issubclass(law, Dissipative) and law.history_rows:
        raise ValueError(f"law {name!r} has a history and a dissipation; no integrator combines them: expected one of the two")
    if law.history_rows > MOST_HISTORY_ROWS:
        raise ValueError(f"law {name!r} has {law.history_rows} history rows, expected at most {MOST_HISTORY_ROWS}")
