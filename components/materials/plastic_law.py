"""The base class of plastic laws, and their two kernel functions.

A law states the equivalent stress q = sqrt(3/2 s:s) at which a material yields, and the return of a trial stress beyond it.
`constants` returns the law for kernels: a named tuple, whose class selects `yield_limit` and `return_stress`.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Literal, NamedTuple

from ..support.dispatch import dispatch_by_class
from ..support.parameter_fields import field
from ..support.tagged_union import Named


class ReturnedStress(NamedTuple):
    """A trial stress after its return to the yield surface.

    Attributes:
        plastic_strain: equivalent plastic strain of the step; 0 inside the surface.
        equivalent: q after the return [Pa].
        pressure: p after the return [Pa].
    """

    plastic_strain: float
    equivalent: float
    pressure: float


class PlasticLaw(Named):
    """The parameters of a law of yield and plastic flow, chosen by its `name`."""

    @abstractmethod
    def constants(self) -> Any:
        """Return the law for kernels, a named tuple; None if it never yields."""


class Elastic(PlasticLaw):
    """A material that never yields."""

    name: Literal["elastic"] = field("elastic", "a material that never yields", "1")

    def constants(self) -> None:
        """Return None, because the material never yields."""
        return


@dispatch_by_class
def yield_limit(law, plastic_strain, pressure):
    """Return the equivalent stress at which the material yields, for a plastic strain and a pressure [Pa]."""


@dispatch_by_class
def return_stress(law, moduli, plastic_strain, equivalent, pressure):
    """Return the `ReturnedStress` of a trial stress.

    Args:
        law: constants of the law.
        moduli: a `Moduli`.
        plastic_strain: equivalent plastic strain before the step.
        equivalent: q of the trial stress [Pa].
        pressure: p of the trial stress [Pa].
    """
