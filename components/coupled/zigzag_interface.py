"""Faces of automata that the grid carries along, where a hexagonal packing meets it; see `automata.zigzag_faces`."""

from __future__ import annotations

import numpy as np

from ..automata.kernel_arrays import Body
from ..automata.loads_and_grips import Conditions
from ..automata.packing import Packing
from ..automata.shapes import ON_THE_OUTLINE
from ..automata.zigzag_faces import Ties, make_ties
from ..errors import ParameterError
from ..grid.mesh import IntArray, Mesh
from .interface import is_upright, spacing
from .places import Places


def find_ties(mesh: Mesh, sides: IntArray, packing: Packing, body: Body, places: Places, conditions: Conditions) -> Ties | None:
    """Return the faces between the automata that stand on upright sides, or on edges that prescribe their motion.

    None where a packing has no zigzag there.

    Args:
        mesh: of the grid.
        sides: of the interface, shape (k, 2): nodes, the grid on the left.
        packing: the automata.
        body: the same, with its material.
        places: the automata by their place.
        conditions: of the edges of the automata.

    Raises:
        ParameterError: the automaton behind a face is cut.
    """
    if packing.lattice.name != "hexagonal":
        return None
    faces = list(conditions.faces)
    upright, level = set[int](), set[int]()
    for side in sides.tolist():
        ends = places.find(mesh.nodes[side])[0].tolist()
        if not is_upright(mesh, packing, side):
            level.update(ends)
            continue
        upright.update(ends)
        faces += _faces_on(mesh, packing, places, side)
    corners = (upright & level) | (conditions.upright & (conditions.level | level))
    return make_ties(body, faces, np.array(sorted(corners), np.int64), packing.reference)


def _faces_on(mesh: Mesh, packing: Packing, places: Places, side: list[int]) -> list[tuple[int, int]]:
    """Return the automata whose faces lie on an upright side, and the slots of these."""
    start, end = mesh.nodes[side[0]], mesh.nodes[side[1]]
    way = end - start
    count = round(abs(float(way[1])) / spacing(packing, True))
    # The grid is on the left.
    inwards = 1.0 if way[1] > 0.0 else -1.0
    middles = start + ((np.arange(count) + 0.5) / count)[:, None] * way + [0.5 * inwards * packing.diameter, 0.0]
    automata, distance = places.find(middles)
    whole = packing.lattice.volume * packing.diameter**2
    cut = packing.classes.volume[packing.kind[automata]] < (1.0 - ON_THE_OUTLINE) * whole
    bad = np.flatnonzero(cut | ~places.is_at(distance))
    if len(bad):
        x, y = middles[bad[0]]
        raise ParameterError(
            f"at ({x:.9g}, {y:.9g}) m, beside the interface, there is no whole automaton",
            expected="at least a diameter of automata behind an upright side",
            hint="make the shape wider there, or take packing = square",
            at=("automata", "shape"),
        )
    slot = 3 if inwards > 0.0 else 0
    return [(one, slot) for one in automata.tolist()]
