"""The base class of reaction laws, and their kernel function."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any, NamedTuple

from ...support.dispatch import dispatch_by_class
from ...support.tagged_union import Named
from ..chapman_jouguet import Detonation
from ..gases import Gas


class ReactionResult(NamedTuple):
    """The unreacted fraction of the gas after a tick, and its pressure, which a law may overwrite [Pa]."""

    fraction: float
    pressure: float


@dispatch_by_class
def advance_reaction(law, density, pressure, fraction, step):
    """Return the `ReactionResult` of a cell.

    Density [kg/m^3], pressure [Pa] and unreacted `fraction` are those before the reaction in a tick of length `step` [s].
    """


class Reaction(Named):
    """A law of the reaction, chosen by its `name`.

    `constants` returns the law for kernels: a named tuple whose class selects `advance_reaction`.
    """

    @abstractmethod
    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> Any:
        """Return the law for kernels.

        Args:
            gas: the gas, with its heat release.
            front: the Chapman-Jouguet detonation of the gas.
            ahead: initial pressure [Pa] and density [kg/m^3].
            cell_size: length of a cell [m].
        """

    def ignition_pressure(self, front: Detonation, ahead: tuple[float, float]) -> float:
        """Return the pressure to which gas must be heated at constant volume to ignite [Pa]; NaN if the law has none."""
        return math.nan

    def cautions(self, cell_size: float) -> list[str]:
        """Return a caution for each assumption of this law that cells of this size violate."""
        return []
