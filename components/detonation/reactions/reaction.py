"""The base of reaction laws, and the functions of a law that kernels call."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any, NamedTuple

from ...support.dispatch import dispatched
from ...support.tagged_union import Named
from ..chapman_jouguet import Detonation
from ..gases import Gas


class Reacted(NamedTuple):
    """The part of the gas that has not reacted after a tick, and the pressure that a law has written over the old one [Pa]."""

    fraction: float
    pressure: float


@dispatched
def react(law, density, pressure, fraction, step):
    """Return the `Reacted` of a cell.

    Args:
        law: constants of the reaction.
        density: [kg/m^3].
        pressure: [Pa].
        fraction: part that has not reacted before the tick.
        step: length of the tick [s].
    """


class Reaction(Named):
    """A law of how the gas reacts, chosen by its `name`.

    `constants` gives the law as kernels see it: a named tuple, whose class selects `react`.
    """

    @abstractmethod
    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> Any:
        """Return the law as kernels see it.

        Args:
            gas: with its heat release.
            front: its Chapman-Jouguet detonation.
            ahead: initial pressure [Pa] and density [kg/m^3].
            cell_size: [m].
        """

    def ignition_pressure(self, front: Detonation, ahead: tuple[float, float]) -> float:
        """Return the pressure to which gas has to be heated at constant volume to ignite [Pa]; NaN where there is none."""
        return math.nan

    def cautions(self, cell_size: float) -> list[str]:
        """Return a sentence for each assumption that this law does not meet on such cells."""
        return []
