"""Grips: what lies beside an edge that a fitting holds, and does not part."""

from __future__ import annotations

from ...errors import ParameterError
from ...support.float_arrays import FloatArray
from ..geometry.bodies import EDGES
from ..kernel_setup import Assembly
from ..parameters import ShellParameters
from .pieces import Marks

# The limit of what does not part: above any stress and strain, its square is finite.
UNBREAKABLE = 1e100
_GRIPPED = ("clamped", "moved")


def points_in_grips(p: ShellParameters, assembly: Assembly, length: float) -> Marks:
    """Return which points lie within a length of an edge that is clamped or moved, shape (m,).

    Raises:
        ParameterError: there is no such edge, or they are all points.
    """
    places: FloatArray = assembly.points.all_places()
    found: Marks = places[:, 0] < -1.0
    for edge, kind in p.boundaries.items():
        if kind in _GRIPPED and length > 0.0:
            number, end = EDGES[edge]
            axis = assembly.lattice.axes[number]
            found |= abs(axis.at(places[:, number]) - axis.positions[end]) < length
    at = ("fracture", "grip_length")
    if length > 0.0 and not any(kind in _GRIPPED for kind in p.boundaries.values()):
        raise ParameterError(f"got {length:g} m, but no edge is {' or '.join(_GRIPPED)}", hint="leave it out", at=at)
    if found.all():
        raise ParameterError(f"got {length:g} m, so that nothing of the body could part", hint="give a smaller one", at=at)
    return found
