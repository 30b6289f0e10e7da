"""The interface of grid and automata: which nodes move with which automata, and the interpolation weights.

The interface consists of the cell sides on the outline of the automata. A side is n diameters long: it has automata at its two
nodes and n - 1 automata between them, whose displacement is interpolated linearly along the side. A hexagonal packing meets the
grid only along its rows, which lie along x.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..automata.packing import Packing
from ..automata.shapes import ON_THE_OUTLINE, Shape
from ..boundaries import Boundary, Free, Traction
from ..errors import ParameterError
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray
from .automaton_search import AutomatonSearch, find_interface_sides, points_in_cells


class Interface(NamedTuple):
    """Nodes and automata that move together.

    Attributes:
        nodes: grid nodes that carry automata, and nodes joined to them by periodic edges, shape (s,).
        automata: numbers of the automata that move with nodes, shape (k,).
        ends: the two nodes between which each of `automata` lies; the same node twice for an automaton on a node, shape (k, 2).
        weights: u = weights[0] u(first node) + weights[1] u(second node), shape (k, 2).
        first: where the automata that act on each node begin in `acting`, and the end of the last ones, shape (s + 1,).
        acting: the automata that act on each node, as indices into `automata`, shape (q,).
        shares: fraction of the force of each acting automaton that acts on the node, shape (q,).
        mass: of the automata that each node carries, joined nodes included, shape (s,) [kg].
        free: 1 for automata that do not belong to the interface, shape (n,).
    """

    nodes: IntArray
    automata: IntArray
    ends: IntArray
    weights: FloatArray
    first: IntArray
    acting: IntArray
    shares: FloatArray
    mass: FloatArray
    free: npt.NDArray[np.uint8]


def find_interface(
    mesh: Mesh,
    boundaries: Mapping[str, Boundary],
    node_groups: IntArray,
    packing: Packing,
    mass: FloatArray,
    shape: Shape,
    origin: FloatArray,
    search: AutomatonSearch,
) -> Interface:
    """Return the interface of a grid and a packing.

    Args:
        mesh: of the grid.
        boundaries: conditions on the edges of the mesh, by name.
        node_groups: groups of nodes that periodic edges join, rows padded with -1, shape (g, 4).
        packing: the automata.
        mass: of each automaton, shape (n,) [kg].
        shape: the shape that the automata fill.
        origin: position of the origin of the shape [m].
        search: search of automata by position.

    Raises:
        ParameterError: the parts overlap, do not touch or do not match, or an interface edge is prescribed or damped.
    """
    sides = find_interface_sides(mesh, shape, origin)
    # Zigzags are refused before overlaps, because the staircase of automata along a zigzag side overlaps cells as well.
    for side in sides.tolist():
        _refuse_zigzags(mesh, packing, side)
    _refuse_overlaps(mesh, packing, search, origin)
    if not len(sides):
        _refuse_gap(mesh, packing, search, origin)
    _refuse_conditions(mesh, boundaries, sides)
    leader = _group_leaders(len(mesh.nodes), node_groups)
    hanging: dict[int, tuple[int, int, float]] = {}
    for side in sides.tolist():
        for automaton, part in _side_automata(mesh, packing, search, side):
            first, second = side if 0.0 < part < 1.0 else (side[round(part)],) * 2
            known = hanging.setdefault(automaton, (first, second, part if 0.0 < part < 1.0 else 0.0))
            if leader[known[0]] != leader[first] and leader[known[0]] != leader[second]:
                raise ParameterError(
                    f"automaton {automaton} belongs to the nodes {known[0]} and {first} of the grid, which move independently",
                    hint="join the nodes by periodic edges, or give the automata no periodic edges",
                    at="automata",
                )
    _refuse_shared_nodes(hanging, leader)
    return _make_interface(hanging, node_groups, mass)


def _refuse_overlaps(mesh: Mesh, packing: Packing, search: AutomatonSearch, origin: FloatArray) -> None:
    """Refuse automata with a sector (a triangle of their cell) whose middle lies in a grid cell: its mass would count twice."""
    automaton, sector = np.nonzero(packing.sectors)
    middles = origin + packing.reference[automaton] + packing.diameter * packing.lattice.sectors.mean(axis=1)[sector]
    # Sectors beyond a periodic side belong to the opposite side of the packing.
    kept = search.are_within_period(middles)
    points, cells = points_in_cells(mesh.nodes, mesh.cells, middles[kept])
    if len(points):
        inside = automaton[kept][points]
        (x, y), (u, v) = (packing.reference[inside[0]] + origin).tolist(), mesh.centres[cells[0]].tolist()
        raise ParameterError(
            f"{len(np.unique(inside))} automata overlap cells of the grid: automaton {inside[0]} at ({x:.9g}, {y:.9g}) m "
            f"overlaps cell {cells[0]} with the centre ({u:.9g}, {v:.9g}) m",
            expected="parts that touch only along sides of cells",
            hint="move `origin`, end the shape of the automata at sides of cells, or leave a hole in the mesh for them",
            at="automata",
        )


def _refuse_gap(mesh: Mesh, packing: Packing, search: AutomatonSearch, origin: FloatArray) -> None:
    """Refuse parts that do not touch; name the nearest node and automaton (a common side would have automata at both nodes)."""
    nodes = np.unique(mesh.sides)
    automata, distance = search.nearest_automata(mesh.nodes[nodes])
    nearest = int(distance.argmin())
    (x, y), (u, v) = mesh.nodes[nodes[nearest]].tolist(), (packing.reference[automata[nearest]] + origin).tolist()
    raise ParameterError(
        "no side of a cell lies on the outline of the automata",
        hint=(
            f"the nearest are node {nodes[nearest]} at ({x:.9g}, {y:.9g}) m and automaton {automata[nearest]} at ({u:.9g}, "
            f"{v:.9g}) m, off by ({x - u:.6g}, {y - v:.6g}) m; move `origin`, or leave a hole in the mesh for the automata"
        ),
        at="automata",
    )


def _refuse_conditions(mesh: Mesh, boundaries: Mapping[str, Boundary], interface_sides: IntArray) -> None:
    """Refuse conditions that prescribe or damp the motion of nodes of `interface_sides`, which are not a free surface."""
    known = {tuple(sorted(side)) for side in interface_sides.tolist()}
    for name, boundary in boundaries.items():
        if isinstance(boundary, (Free, Traction)):
            continue
        for start, end in mesh.edges[name].tolist():
            if (min(start, end), max(start, end)) in known:
                (x, y), (u, v) = mesh.nodes[start].tolist(), mesh.nodes[end].tolist()
                raise ParameterError(
                    f"got {boundary.name!r} on the interface between ({x:.6g}, {y:.6g}) and ({u:.6g}, {v:.6g}) m",
                    expected="free or traction",
                    hint="an edge on the interface is not a surface of the body",
                    at=("grid", "boundaries", name),
                )


def _refuse_zigzags(mesh: Mesh, packing: Packing, side: list[int]) -> None:
    """Refuse an interface side along the zigzag of a hexagonal packing, i.e. not along its rows."""
    way = mesh.nodes[side[1]] - mesh.nodes[side[0]]
    if packing.lattice.name == "hexagonal" and abs(way[1]) > ON_THE_OUTLINE * packing.diameter:
        x, y = mesh.nodes[side[0]]
        raise ParameterError(
            f"at ({x:.9g}, {y:.9g}) m the interface does not lie along the rows of the hexagonal packing",
            expected="sides along x only",
            hint="turn the body by 90 degrees, so that the grid meets rows of automata, or take packing = square",
            at=("automata", "packing"),
        )


def _side_automata(mesh: Mesh, packing: Packing, search: AutomatonSearch, side: list[int]) -> list[tuple[int, float]]:
    """Return the automata on an interface side and their positions along it, from 0 to 1."""
    start, end = mesh.nodes[side[0]], mesh.nodes[side[1]]
    way = end - start
    count = float(np.sqrt(way[0] * way[0] + way[1] * way[1])) / packing.diameter
    where = f"interface between ({start[0]:.9g}, {start[1]:.9g}) m and ({end[0]:.9g}, {end[1]:.9g}) m, nodes {side}"
    if round(count) < 1 or abs(count - round(count)) > ON_THE_OUTLINE * max(count, 1.0):
        raise ParameterError(
            f"the {where}, is {count:.9g} diameters of {packing.diameter:g} m long",
            expected="a whole number of diameters",
            at="automata.diameter",
        )
    parts = np.arange(round(count) + 1) / round(count)
    points = start + parts[:, None] * way
    automata, distance = search.nearest_automata(points)
    off = np.flatnonzero(~search.is_at_point(distance))
    if len(off):
        x, y = points[off[0]]
        raise ParameterError(
            f"on the {where}, an automaton is expected at ({x:.9g}, {y:.9g}) m",
            hint=f"the nearest one is {distance[off[0]]:.6g} m away; move `origin`, or change the shape",
            at="automata",
        )
    return list(zip(automata.tolist(), parts.tolist(), strict=True))


def _refuse_shared_nodes(interface_automata: dict[int, tuple[int, int, float]], leader: IntArray) -> None:
    """Refuse two automata at one node, or at nodes that periodic edges join: the automata could only move together."""
    on: dict[int, int] = {}
    for automaton, (first, second, _) in interface_automata.items():
        if first == second and (other := on.setdefault(int(leader[first]), automaton)) != automaton:
            raise ParameterError(
                f"automata {other} and {automaton} would both follow node {leader[first]}; periodic edges of the grid join it",
                hint="give the automata periodic edges too, or the grid none",
                at="automata",
            )


def _group_leaders(count: int, node_groups: IntArray) -> IntArray:
    """Return for each node the first node of its group of joined nodes, shape (count,)."""
    leader = np.arange(count)
    for group in node_groups:
        leader[group[group >= 0]] = group[0]
    return leader


def _make_interface(hanging: dict[int, tuple[int, int, float]], node_groups: IntArray, mass: FloatArray) -> Interface:
    automata = np.array(sorted(hanging), dtype=np.int64)
    ends = np.array([hanging[one][:2] for one in automata.tolist()], dtype=np.int64)
    part = np.array([hanging[one][2] for one in automata.tolist()])
    weights = np.stack([1.0 - part, part], axis=1)
    acts: dict[int, list[tuple[int, float]]] = {}
    for place, (nodes, both) in enumerate(zip(ends.tolist(), weights.tolist(), strict=True)):
        for node, weight in zip(nodes, both, strict=True):
            if weight > 0.0:
                acts.setdefault(node, []).append((place, weight))
    for group in node_groups.tolist():
        members = [node for node in group if node >= 0]
        common = sorted(pair for node in members for pair in acts.get(node, []))
        if common:
            acts.update(dict.fromkeys(members, common))
    nodes = sorted(acts)
    acting = np.array([place for node in nodes for place, _ in acts[node]], dtype=np.int64)
    shares = np.array([share for node in nodes for _, share in acts[node]])
    first = np.cumsum([0, *(len(acts[node]) for node in nodes)]).astype(np.int64)
    free = np.ones(len(mass), dtype=np.uint8)
    free[automata] = 0
    carried = shares * mass[automata[acting]]
    total = np.array([carried[begin:end].sum() for begin, end in zip(first, first[1:], strict=False)])
    return Interface(np.array(nodes, dtype=np.int64), automata, ends, weights, first, acting, shares, total, free)


def carried_mass(interface: Interface, count: int, mass: FloatArray) -> FloatArray:
    """Return the mass of the automata that each node carries, without those of joined nodes, shape (count,) [kg]."""
    found = np.zeros(count)
    for column in (0, 1):
        np.add.at(found, interface.ends[:, column], interface.weights[:, column] * mass[interface.automata])
    return found
