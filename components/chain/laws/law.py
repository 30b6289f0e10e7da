"""What a contact law declares of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ...support.roots import two_thirds_power
from ...support.tagged_union import Named
from ..layout import HERTZ, NONE

FloatArray = npt.NDArray[np.float64]


class Law(Named):
    """A contact law, chosen by its `name`: parameters here, the formula in jitted functions beside it."""

    exponent: ClassVar[float]
    """The exponent p with which the force grows with the overlap, F ~ d^p; a law may make a parameter of it."""
    elastic: ClassVar[int] = HERTZ
    """Which elastic force the kernels take."""
    damping: ClassVar[int] = NONE
    """Which dissipation beside it."""
    has_history: ClassVar[bool] = False
    """Whether the force depends on what the contact has been through."""
    needs_stiffness: ClassVar[bool] = False
    """Whether `contact_stiffness` has to be given, because radii and materials do not tell it."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, real: slice
    ) -> FloatArray:
        """The one number that the law wants of each contact, in the table's row CONTACT, shape (contacts,).

        Args:
            stiffness: of each place, shape (n + 1,), as the other arrays.
            reduced_radius: R* [m].
            yield_strength: of the weaker side [Pa].
            real: which places are contacts.
        """
        return np.zeros(real.stop - real.start)

    def overlap_at(self, force: FloatArray, stiffness: FloatArray, constants: FloatArray) -> FloatArray:
        """The overlap at which a contact that was never loaded before carries a force, shape (contacts,) [m]."""
        return two_thirds_power(force / stiffness)

    @property
    def conservative(self) -> bool:
        """Whether it gives back all energy."""
        return self.damping == NONE and not self.has_history


class Dissipative(Law, ABC):
    """A law whose force depends on the speed of approach, by a coefficient for each contact."""

    dissipation: Any
    jumps: ClassVar[bool] = False
    """Whether the force jumps where a contact closes."""

    def contact_constants(
        self, stiffness: FloatArray, reduced_radius: FloatArray, yield_strength: FloatArray, real: slice
    ) -> FloatArray:
        """The dissipation."""
        return (np.zeros(len(stiffness)) + np.asarray(self.dissipation))[real]

    @abstractmethod
    def coefficients(self, constants: FloatArray, overlap: FloatArray) -> FloatArray:
        """Force per speed of approach at an overlap, shape (contacts,) [N s/m]."""

    @abstractmethod
    def overlap_of(self, constants: FloatArray, coefficients: FloatArray) -> FloatArray:
        """The overlap beyond which force per speed is above `coefficients`; 0: at once, inf: never; shape (contacts,) [m]."""
