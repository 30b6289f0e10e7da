"""Conditions of the domain's edges, by name: free, fixed, symmetry, periodic, velocity, traction, absorbing."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import SerializeAsAny

from ..support.fields import field
from ..support.tagged_union import ByName, Named

Along = Literal["edge", "nodes"]


class Boundary(Named):
    """A condition of an edge of the domain, chosen by its `name`."""

    precedence: ClassVar[int] = 0
    """Of two edges that prescribe one component of the velocity of their common node, the one with more wins."""


class Free(Boundary):
    """No traction."""

    name: Literal["free"] = field("free", "no traction", "1")


class Fixed(Boundary):
    """Nodes that do not move."""

    precedence: ClassVar[int] = 3
    name: Literal["fixed"] = field("fixed", "nodes that do not move", "1")


class Symmetry(Boundary):
    """A mirror: nodes slide along the edge, which lies along x or along y."""

    precedence: ClassVar[int] = 1
    name: Literal["symmetry"] = field("symmetry", "a mirror: nodes slide along the edge", "1")


class Periodic(Boundary):
    """A joined edge: what leaves here enters at the opposite edge, which is periodic too; their nodes move as one."""

    name: Literal["periodic"] = field("periodic", "joined to the opposite edge", "1")
    partner: str = field("", "the opposite edge; may be left out for left, right, bottom and top", "1")


class PrescribedVelocity(Boundary):
    """Nodes move with the velocity that the input `<edge>_velocity` gives."""

    precedence: ClassVar[int] = 2
    name: Literal["velocity"] = field("velocity", "prescribed velocity, an input", "1")
    components: Literal["both", "x", "y"] = field("both", "which components are prescribed; the other one is free", "1")
    along: Along = field("edge", "edge: one velocity for the edge; nodes: one for each of its nodes", "1")


class Traction(Boundary):
    """A force per area, the input `<edge>_traction`: of the area before anything moved, in fixed directions x and y."""

    name: Literal["traction"] = field("traction", "prescribed traction, an input", "1")
    along: Along = field("edge", "edge: one traction for the edge; nodes: one for each of its nodes, linear between", "1")


class Absorbing(Boundary):
    """Dashpots of the medium's impedance (Lysmer and Kuhlemeyer), and before them a layer in which waves decay, if wanted.

    J. Lysmer, R. L. Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859: traction -rho c_p v_n along the normal, -rho c_s v_t
    along the edge; nothing of a plane wave at normal incidence comes back. The layer (sponge) has the damping force
    -m (strength c_p / width) (depth / width)^2 v: a P wave that crosses it twice keeps exp(-strength / 3) of its amplitude.
    """

    name: Literal["absorbing"] = field("absorbing", "lets waves out", "1")
    sponge_width: float = field(0.0, "width of the damping layer inside the edge; 0: dashpots alone", "m", ge=0.0)
    sponge_strength: float = field(
        10.0, "damping rate of the layer at the edge, in units of c_p / width",
        "1", ge=0.0, le=1000.0,
    )  # fmt: skip


BOUNDARIES: dict[str, type[Boundary]] = {
    "free": Free,
    "fixed": Fixed,
    "symmetry": Symmetry,
    "periodic": Periodic,
    "velocity": PrescribedVelocity,
    "traction": Traction,
    "absorbing": Absorbing,
}

ChosenBoundary = Annotated[SerializeAsAny[Boundary], ByName(BOUNDARIES)]
