"""Boundary conditions of the edges, by name: free, fixed, symmetry, periodic, velocity, traction, absorbing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import SerializeAsAny

from .. import boundaries
from ..boundaries import Boundary, Fixed, Free, Symmetry
from ..support.parameter_fields import field
from ..support.tagged_union import ByName

__all__ = [
    "BOUNDARIES", "Absorbing", "Boundary", "ChosenBoundary", "Fixed", "Free", "Periodic", "PrescribedVelocity", "Symmetry",
    "Traction",
]  # fmt: skip

Along = Literal["edge", "nodes"]


class Periodic(boundaries.Periodic):
    """A joined edge: waves that leave here enter at the opposite edge, which is periodic too; their nodes move together."""

    partner: str = field("", "opposite edge; optional for left, right, bottom and top", "1")


class PrescribedVelocity(boundaries.PrescribedVelocity):
    """Nodes move at the velocity of the input `<edge>_velocity`."""

    along: Along = field("edge", "edge: one velocity for the whole edge; nodes: one for each node", "1")


class Traction(boundaries.Traction):
    """A force per initial area, the input `<edge>_traction`, in the fixed directions x and y."""

    along: Along = field("edge", "edge: one traction for the whole edge; nodes: one for each node, linear between them", "1")


class Absorbing(Boundary):
    """Dashpots with the impedance of the medium (Lysmer and Kuhlemeyer), and an optional damping layer in front of them.

    J. Lysmer, R. L. Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859: traction -rho c_p v_n along the normal, -rho c_s v_t
    along the edge; a plane wave at normal incidence is not reflected. The layer (sponge) has the damping force
    -m (strength c_p / width) (depth / width)^2 v: a P wave that crosses it twice keeps exp(-strength / 3) of its amplitude.
    At the edge, the traction of the stress at the reset keeps acting, and the forces of the dashpots are added to it.
    """

    name: Literal["absorbing"] = field("absorbing", "absorbs waves", "1")
    sponge_width: float = field(0.0, "width of the damping layer inside the edge; 0: only dashpots", "m", ge=0.0)
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
