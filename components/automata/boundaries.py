"""Conditions of a specimen's edges, by name: free, fixed, symmetry, periodic, velocity, traction.

They are those of the grid. Automata also turn, except those that are fixed, mirrored, or moved across their edge.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from .. import boundaries
from ..boundaries import Boundary, Free, Periodic, Symmetry, Traction
from ..support.parameter_fields import field
from ..support.tagged_union import ByName

__all__ = [
    "BOUNDARIES",
    "Boundary",
    "ChosenBoundary",
    "Fixed",
    "Free",
    "Periodic",
    "PrescribedVelocity",
    "Symmetry",
    "Traction",
]


class Fixed(boundaries.Fixed):
    """Automata that neither move nor turn."""

    depth: float = field(0.0, "how far from the outermost automaton it reaches", "m", ge=0.0)


class PrescribedVelocity(boundaries.PrescribedVelocity):
    """Automata move with the velocity that the input `<edge>_velocity` gives.

    A plate that prescribes the component across its edge alone is smooth: automata slide along it and do not turn, as on a
    plane of symmetry. Automata of an edge that prescribes the component along it alone turn freely.
    """

    depth: float = field(0.0, "how far from the outermost automaton it reaches", "m", ge=0.0)


BOUNDARIES: dict[str, type[Boundary]] = {
    "free": Free,
    "fixed": Fixed,
    "symmetry": Symmetry,
    "periodic": Periodic,
    "velocity": PrescribedVelocity,
    "traction": Traction,
}

ChosenBoundary = Annotated[SerializeAsAny[Boundary], ByName(BOUNDARIES)]
