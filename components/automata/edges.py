"""The four edges of a specimen: which automata belong to each, and how a traction is shared out."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from .packing import Packing
from .shapes import ON_THE_OUTLINE

# Edge -> axis across it, and whether it is at the far end of that axis.
EDGES = {"left": (0, False), "right": (0, True), "bottom": (1, False), "top": (1, True)}


def edge_automata(packing: Packing, name: str, depth: float = 0.0) -> npt.NDArray[np.int64]:
    """Return the automata within a depth [m] of the outermost one of an edge, shape (m,); of a zigzag both rows."""
    axis, far = EDGES[name]
    place = packing.reference[:, axis] * (1.0 if far else -1.0)
    zigzag = 0.5 * packing.diameter if packing.lattice.name == "hexagonal" and axis == 0 else 0.0
    reach = max(depth, zigzag) + ON_THE_OUTLINE * packing.diameter
    return np.flatnonzero(place >= place.max() - reach).astype(np.int64)


def shared_areas(packing: Packing, name: str, automata: npt.NDArray[np.int64], area: float) -> FloatArray:
    """Return what part of the area of a straight edge belongs to each of its automata, shape (m,) [m^2].

    On a zigzag the half cells that stand out have twice the length of the whole cells between them.
    """
    kinds = packing.kind[automata]
    part = packing.classes.volume[kinds].copy()
    if packing.lattice.name == "hexagonal" and EDGES[name][0] == 0:
        part[packing.classes.missing[kinds] == 0.0] *= 4.0
    return area * part / part.sum()


def traction_levers(packing: Packing, name: str, automata: npt.NDArray[np.int64]) -> FloatArray:
    """Return how far from the centres of an edge's automata a traction acts, shape (m, 2) [m]; see `motion.Load`.

    A quarter cell is loaded on one side of its centre only, at a mean distance of D / 4 along a row. Along a zigzag the
    distance is sqrt(3) D / 8 and not that of the middle of the side, because the halved face of the row acts at the height
    of the centre as well. Without the torque the quarter cells of a hexagonal packing would turn under a homogeneous
    stress. In a square packing the two halved faces cancel it.
    """
    levers, axis = np.zeros((len(automata), 2)), EDGES[name][0]
    if packing.lattice.name == "hexagonal":
        volume = packing.classes.volume[packing.kind[automata]]
        quarter = volume < (0.25 + ON_THE_OUTLINE) * packing.lattice.volume * packing.diameter**2
        place = packing.reference[automata, 1 - axis]
        inward = np.sign(0.5 * (place.min() + place.max()) - place)
        levers[:, 1 - axis] = np.where(
            quarter, 0.25 * packing.diameter * (1.0 if axis == 1 else packing.lattice.volume) * inward, 0.0
        )
    return levers
