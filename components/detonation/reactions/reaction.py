"""The base of reaction laws, and their codes for kernels."""

from __future__ import annotations

import math
from typing import ClassVar

from ...support.float_arrays import FloatArray
from ...support.tagged_union import Named
from ..chapman_jouguet import Detonation
from ..gases import Gas

INERT, PRESSURE_BURN, ARRHENIUS, CONSTANT_VOLUME = 0, 1, 2, 3
CONSTANTS = 4


class Reaction(Named):
    """A law of how the gas reacts, chosen by its `name`."""

    code: ClassVar[int]

    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> tuple[float, ...]:
        """Return up to CONSTANTS numbers for the kernel.

        Args:
            gas: with its heat release.
            front: its Chapman-Jouguet detonation.
            ahead: initial pressure [Pa] and density [kg/m^3].
            cell_size: [m].
        """
        return ()

    def ignition_pressure(self, front: Detonation, ahead: tuple[float, float]) -> float:
        """Return the pressure to which gas has to be heated at constant volume to ignite [Pa]; NaN where there is none."""
        return math.nan

    def describe_ignition(self, constants: FloatArray, peak: float, density: FloatArray, pressure: FloatArray) -> str:
        """Return how near gas that has not ignited came to it.

        Args:
            constants: of the kernel.
            peak: largest pressure so far [Pa].
            density: now, shape (n,) [kg/m^3].
            pressure: now, shape (n,) [Pa].
        """
        return f"its largest pressure was {1e-3 * peak:.4g} kPa"

    def cautions(self, cell_size: float) -> list[str]:
        """Return a sentence for each assumption that this law does not meet on such cells."""
        return []
