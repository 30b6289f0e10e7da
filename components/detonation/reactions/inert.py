"""The law of a gas that does not react."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...support.parameter_fields import field
from ..chapman_jouguet import Detonation
from ..gases import Gas
from .reaction import Reaction, ReactionResult, advance_reaction


class InertConstants(NamedTuple):
    """A gas that does not react has no constants."""


class Inert(Reaction):
    """A gas that does not react."""

    name: Literal["inert"] = field("inert", "no reaction", "1")

    def constants(self, gas: Gas, front: Detonation, ahead: tuple[float, float], cell_size: float) -> InertConstants:
        """Return an empty tuple, whose class selects this law in kernels."""
        return InertConstants()


@advance_reaction.register(InertConstants)
def _advance_reaction(law, density, pressure, fraction, step):
    return ReactionResult(fraction, pressure)
