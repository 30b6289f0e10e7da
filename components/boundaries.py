"""Boundary conditions, by name, that several components share for the edges of plane bodies.

Components add their own conditions and specialise these; see `grid.boundaries`, `automata.parameters`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .support.parameter_fields import field
from .support.tagged_union import Named
from .variables import Variable

OPPOSITE = {"left": "right", "right": "left", "bottom": "top", "top": "bottom"}


class Boundary(Named):
    """A boundary condition of an edge, chosen by its `name`."""

    precedence: ClassVar[int] = 0
    """Rank for nodes where two edges prescribe the same velocity component: the edge with the higher rank applies."""


class Free(Boundary):
    """No traction."""

    name: Literal["free"] = field("free", "no traction", "1")


class Fixed(Boundary):
    """An edge that does not move."""

    precedence: ClassVar[int] = 3
    name: Literal["fixed"] = field("fixed", "the edge does not move", "1")


class Symmetry(Boundary):
    """A mirror: nodes or automata slide along the edge, which lies along x or along y."""

    precedence: ClassVar[int] = 1
    name: Literal["symmetry"] = field("symmetry", "a mirror plane: nodes or automata slide along the edge", "1")


class Periodic(Boundary):
    """A periodic edge: waves that leave through it enter at the opposite edge, which is periodic too."""

    name: Literal["periodic"] = field("periodic", "joined to the opposite edge", "1")


class PrescribedVelocity(Boundary):
    """The edge moves at the velocity of the input `<edge>_velocity`."""

    precedence: ClassVar[int] = 2
    name: Literal["velocity"] = field("velocity", "prescribed velocity, an input", "1")
    components: Literal["both", "x", "y"] = field("both", "prescribed velocity components; the other component is free", "1")

    @property
    def prescribed_axes(self) -> tuple[int, ...]:
        """Return the components of the velocity that the edge prescribes: 0 for x, 1 for y."""
        return (0, 1) if self.components == "both" else (("x", "y").index(self.components),)


class Traction(Boundary):
    """A force per initial area, along the fixed directions x and y: the input `<edge>_traction`."""

    name: Literal["traction"] = field("traction", "prescribed traction, an input", "1")


def edge_variable(edge: str, boundary: Traction | PrescribedVelocity) -> Variable:
    """Return the input of an edge, its velocity or traction: one vector that holds for the whole edge."""
    quantity, unit, text = ("traction", "Pa", "force per area on")
    if isinstance(boundary, PrescribedVelocity):
        quantity, unit, text = ("velocity", "m/s", "velocity of")
    text = f"{text} the {edge} edge, along x and y"
    return Variable(f"{edge}_{quantity}", "input", unit, (2,), text, start=0.0, axes=("direction",))


def prescribed_components(
    boundaries: Mapping[str, Boundary],
    members: Callable[[str], npt.NDArray[np.int64]],
    components: Callable[[str, Boundary], tuple[int, ...]],
) -> dict[int, dict[int, str]]:
    """Return, for each node or automaton, the edges that prescribe components of its velocity: member -> component -> edge.

    Args:
        boundaries: boundary of each edge, by name.
        members: function that returns the numbers of the nodes or automata on an edge.
        components: function that returns the components that a boundary prescribes on an edge.
    """
    found: dict[int, dict[int, str]] = {}
    for name in sorted(boundaries, key=lambda name: boundaries[name].precedence):
        boundary = boundaries[name]
        if isinstance(boundary, (Fixed, PrescribedVelocity, Symmetry)):
            given = components(name, boundary)
            for member in members(name).tolist():
                found.setdefault(member, {}).update(dict.fromkeys(given, name))
    return found
