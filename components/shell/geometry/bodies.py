"""Bodies, by name: a plate, a tube, a rod."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import SerializeAsAny

from ...support.parameter_fields import Magnitude, field
from ...support.tagged_union import ByName, Named
from .axis import Axis, closed_axis, even_axis, refuse_coinciding_planes
from .lattice import Lattice
from .notch import Notch, notched_lattice

# Largest number of planes of nodes along a body, and through it (the number of Gauss points is then one less).
MOST_PLANES, MOST_LAYERS = 1_000_000, 9
_AT_MOST = f"at most {MOST_LAYERS}, i.e. {MOST_LAYERS - 1} Gauss points"
# The names of the two ends of each of the three axes of a lattice.
EDGES = {"start": (0, 0), "end": (0, -1), "left": (1, 0), "right": (1, -1), "bottom": (2, 0), "top": (2, -1)}


class BodyShape(Named):
    """A body, chosen by its `name`."""

    def lattice(self) -> Lattice:
        """Return the nodes of the body."""
        raise NotImplementedError

    @property
    def node_counts(self) -> tuple[int, int, int]:
        """Numbers of nodes along, across and through."""
        raise NotImplementedError

    @property
    def edges(self) -> tuple[str, ...]:
        """Names of the edges of the body."""
        return tuple(EDGES)


class Plate(BodyShape):
    """A plate from the origin along x, y and z."""

    name: Literal["plate"] = field("plate", "a plate: length along x, width along y, thickness along z", "1")
    length: Magnitude = field(0.02, "along x", "m")
    width: Magnitude = field(0.01, "along y", "m")
    thickness: Magnitude = field(0.00089, "along z", "m")
    along: int = field(21, "planes of nodes along x", "1", ge=3, le=MOST_PLANES)
    across: int = field(11, "planes of nodes along y", "1", ge=3, le=MOST_PLANES)
    layers: int = field(3, f"planes of nodes along z, including both surfaces: {_AT_MOST}", "1", ge=2, le=MOST_LAYERS)
    notch: Notch | None = field(None, "a slot in the upper surface", "1", absent="none")

    def lattice(self) -> Lattice:
        """Return the lattice of its nodes."""
        along, across = even_axis(self.length, self.along), even_axis(self.width, self.across)
        if self.notch is not None:
            return notched_lattice(self.notch, (along, across), 0.0, self.thickness, self.layers, is_bent=False)
        return Lattice((along, across, even_axis(self.thickness, self.layers)), bent=False)

    @property
    def node_counts(self) -> tuple[int, int, int]:
        """Numbers of nodes along, across and through."""
        return self.along, self.across, self.layers


class Rod(BodyShape):
    """A rod of square cross-section from the origin along x."""

    name: Literal["rod"] = field("rod", "a square rod along x", "1")
    length: Magnitude = field(0.03, "along x", "m")
    side: Magnitude = field(0.006, "along y and z", "m")
    along: int = field(31, "planes of nodes along x", "1", ge=3, le=MOST_PLANES)
    across: int = field(7, f"planes of nodes along y and along z: {_AT_MOST}", "1", ge=3, le=MOST_LAYERS)

    def lattice(self) -> Lattice:
        """Return the lattice of its nodes."""
        side = even_axis(self.side, self.across)
        return Lattice((even_axis(self.length, self.along), side, side), bent=False)

    @property
    def node_counts(self) -> tuple[int, int, int]:
        """Numbers of nodes along, across and through."""
        return self.along, self.across, self.across


class Tube(BodyShape):
    """A tube around the x axis; by default a piece of the tube of Gato & Shie (2010)."""

    name: Literal["tube"] = field("tube", "a tube around the x axis", "1")
    length: Magnitude = field(0.02, "along x", "m")
    inner_radius: Magnitude = field(0.01975, "radius of the inner surface", "m")
    wall: Magnitude = field(0.00089, "thickness of the wall", "m")
    along: int = field(21, "planes of nodes along x", "1", ge=3, le=MOST_PLANES)
    around: int = field(
        96, "planes of nodes around the axis (half tube: including both planes of symmetry)", "1", ge=4, le=MOST_PLANES
    )
    layers: int = field(3, f"nodes through the wall, including both surfaces: {_AT_MOST}", "1", ge=2, le=MOST_LAYERS)
    half: bool = field(False, "model only y >= 0, with y = 0 as a plane of symmetry", "1")
    notch: Notch | None = field(None, "a slot in the outer surface", "1", absent="none")

    def lattice(self) -> Lattice:
        """Return the lattice of its nodes."""
        ring = even_axis(math.pi, self.around) if self.half else closed_axis(2.0 * math.pi, self.around)
        along = even_axis(self.length, self.along)
        wall = Axis(self.inner_radius + self.wall * (np.arange(self.layers) / (self.layers - 1)))
        refuse_coinciding_planes(wall, self.wall, "wall")
        if self.notch is not None:
            return notched_lattice(self.notch, (along, ring), self.inner_radius, self.wall, self.layers, is_bent=True)
        return Lattice((along, ring, wall), bent=True)

    @property
    def node_counts(self) -> tuple[int, int, int]:
        """Numbers of nodes along, around and through."""
        return self.along, self.around, self.layers

    @property
    def edges(self) -> tuple[str, ...]:
        """Names of the edges; the edges of a half tube at y = 0 are always planes of symmetry."""
        return ("start", "end")


BODIES: dict[str, type[BodyShape]] = {"plate": Plate, "tube": Tube, "rod": Rod}
ChosenBody = Annotated[SerializeAsAny[BodyShape], ByName(BODIES)]
