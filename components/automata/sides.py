"""The four sides of a specimen: which automata belong to each, what is prescribed there, and how a traction is shared out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..support.arrays import FloatArray
from .motion import HOLDS_ROTATION, HOLDS_X, HOLDS_Y
from .packing import Packing
from .shapes import ON_THE_OUTLINE

SideKind = Literal["free", "fixed", "symmetry", "platen", "velocity", "traction", "periodic"]
# Side -> axis across it, and whether it is at the far end of that axis.
SIDES = {"left": (0, False), "right": (0, True), "bottom": (1, False), "top": (1, True)}


@dataclass(frozen=True)
class Side:
    """One side of a specimen.

    Attributes:
        name: "left", "right", "bottom" or "top".
        kind: what is prescribed there.
        automata: of the side, shape (m,).
    """

    name: str
    kind: str
    automata: npt.NDArray[np.int64]

    @property
    def axis(self) -> int:
        """The axis across the side: 0 for x, 1 for y."""
        return SIDES[self.name][0]

    @property
    def held(self) -> int:
        """Return what is held of each automaton, as `motion.Grip` says."""
        across = (HOLDS_X, HOLDS_Y)[self.axis]
        return {
            "fixed": HOLDS_X | HOLDS_Y | HOLDS_ROTATION,
            "velocity": HOLDS_X | HOLDS_Y | HOLDS_ROTATION,
            "symmetry": across | HOLDS_ROTATION,
            "platen": across,
        }.get(self.kind, 0)


def find_sides(packing: Packing, kinds: dict[str, str], depth: float) -> list[Side]:
    """Return the sides that are not free.

    Args:
        packing: the automata.
        kinds: side -> what is prescribed there.
        depth: how far from the outermost automaton a side reaches [m].
    """
    return [
        Side(name, kind, side_automata(packing, name, depth))
        for name, kind in kinds.items()
        if kind not in ("free", "periodic")
    ]


def side_automata(packing: Packing, name: str, depth: float = 0.0) -> npt.NDArray[np.int64]:
    """Return the automata of a side; of a zigzag both rows."""
    axis, far = SIDES[name]
    place = packing.reference[:, axis] * (1.0 if far else -1.0)
    zigzag = 0.5 * packing.diameter if packing.lattice.name == "hexagonal" and axis == 0 else 0.0
    reach = max(depth, zigzag) + ON_THE_OUTLINE * packing.diameter
    return np.flatnonzero(place >= place.max() - reach).astype(np.int64)


def shared_areas(packing: Packing, side: Side, area: float) -> FloatArray:
    """Return what part of the area of a straight side belongs to each of its automata, shape (m,) [m^2].

    On a zigzag the half cells that stand out have twice the length of the whole cells between them.
    """
    kinds = packing.kind[side.automata]
    part = packing.classes.volume[kinds].copy()
    if packing.lattice.name == "hexagonal" and side.axis == 0:
        part[packing.classes.missing[kinds] == 0.0] *= 4.0
    return area * part / part.sum()
