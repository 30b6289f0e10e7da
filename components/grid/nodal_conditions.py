"""Nodes with conditions, derived from boundaries and inputs: node numbers, prescribed components, and the action of inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import boundaries as shared
from ..boundaries import OPPOSITE, edge_variable
from ..errors import ParameterError
from ..support.float_arrays import FloatArray
from ..variables import Variable
from .boundaries import Absorbing, Boundary, Fixed, Periodic, PrescribedVelocity, Symmetry, Traction
from .mesh import IntArray, Mesh

# Nodes of two edges count as opposite within this tolerance, as a fraction of the distance between the edges.
_MISFIT = 1e-9


@dataclass(frozen=True)
class EdgeInput:
    """An input and its action on nodes.

    Attributes:
        variable: the input.
        nodes: nodes on which it acts, shape (k,).
        velocity: whether it prescribes a velocity; otherwise it is a force or a traction.
        sides: for a traction, the two nodes of each side of the edge, as indices into `nodes`, shape (sides, 2).
        lengths: lengths of these sides, shape (sides,) [m].
        own: for a velocity, whether this edge (not another one) prescribes each component of each node, shape (k, 2).
    """

    variable: Variable
    nodes: IntArray
    velocity: bool = False
    sides: IntArray | None = None
    lengths: FloatArray | None = None
    own: npt.NDArray[np.bool_] | None = None

    def nodal_values(self, value: Any) -> FloatArray:
        """Return the forces [N] or velocities [m/s] of the nodes for a value of the input, shape (k, 2)."""
        rows = np.broadcast_to(np.asarray(value).reshape(-1, 2), (len(self.nodes), 2))
        if self.own is not None:
            return np.where(self.own, rows, 0.0)
        if self.sides is None or self.lengths is None:
            return rows
        # Exact work of a traction linear along each side on displacements linear along it, for unit thickness.
        third, sixth = self.lengths[:, None] / 3.0, self.lengths[:, None] / 6.0
        first, second = rows[self.sides[:, 0]], rows[self.sides[:, 1]]
        given = np.zeros((len(self.nodes), 2))
        np.add.at(given, self.sides[:, 0], third * first + sixth * second)
        np.add.at(given, self.sides[:, 1], third * second + sixth * first)
        return given


def joined_nodes(mesh: Mesh, boundaries: Mapping[str, Boundary]) -> IntArray:
    """Return the groups of nodes that periodic edges join, rows padded with -1, shape (k, 4).

    Raises:
        ParameterError: an edge has no partner, or the nodes of the two edges do not lie opposite each other.
    """
    pairs: list[IntArray] = []
    for name, boundary in boundaries.items():
        if isinstance(boundary, Periodic):
            partner = boundary.partner or OPPOSITE.get(name, "")
            other = boundaries.get(partner)
            if not isinstance(other, Periodic) or (other.partner or OPPOSITE.get(partner, "")) != name:
                raise ParameterError(f"is periodic, so its partner {partner!r} has to be periodic too", at=("boundaries", name))
            if name < partner:
                pairs.append(_opposite_nodes(mesh, name, partner))
    if not pairs:
        return np.zeros((0, 4), dtype=np.int64)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    linked = np.concatenate(pairs)
    graph = coo_array((np.ones(len(linked)), linked.T), shape=(len(mesh.nodes), len(mesh.nodes)))
    _, group = connected_components(graph, directed=False)
    members: dict[int, list[int]] = {}
    for node in np.unique(linked).tolist():
        members.setdefault(int(group[node]), []).append(node)
    rows = np.full((len(members), 4), -1, dtype=np.int64)
    for row, nodes in zip(rows, members.values(), strict=True):
        if len(nodes) not in (2, 4):
            raise ParameterError(
                f"periodic edges join the nodes {nodes}", expected="two, or four at a corner of the domain", at="boundaries"
            )
        row[: len(nodes)] = nodes
    return rows


def _opposite_nodes(mesh: Mesh, first: str, second: str) -> IntArray:
    """Return the pairs of nodes of two edges whose positions differ by the same vector, shape (k, 2)."""
    one, two = mesh.sorted_edge_nodes(first), mesh.sorted_edge_nodes(second)
    if len(one) != len(two):
        raise ParameterError(
            f"has {len(one)} nodes, and {second} has {len(two)}",
            hint="periodic edges need equal numbers of nodes",
            at=("boundaries", first),
        )
    way = mesh.nodes[two] - mesh.nodes[one]
    if np.abs(way - way[0]).max() > _MISFIT * np.abs(way[0]).max():
        raise ParameterError(
            f"its nodes do not lie opposite the nodes of {second}, as periodic edges require", at=("boundaries", first)
        )
    return np.stack([one, two], axis=1)


def edge_inputs(
    mesh: Mesh,
    boundaries: Mapping[str, Boundary],
    forced_nodes: Sequence[int],
    edge_components: Mapping[str, tuple[IntArray, npt.NDArray[np.bool_]]],
) -> list[EdgeInput]:
    """Return the inputs of a grid: tractions, velocities, forces on nodes; `edge_components` is the result of `held_edges`."""
    found = []
    for name, boundary in boundaries.items():
        if isinstance(boundary, Traction):
            sides = np.searchsorted(np.sort(mesh.edge_nodes(name)), mesh.edges[name])
            sides = np.argsort(mesh.edge_nodes(name), kind="stable")[sides]
            variable, lengths = _edge_variable(mesh, name, boundary), mesh.side_lengths(mesh.edges[name])
            found.append(EdgeInput(variable, mesh.edge_nodes(name), sides=sides, lengths=lengths))
        elif isinstance(boundary, PrescribedVelocity):
            nodes, own = edge_components[name]
            variable = _edge_variable(mesh, name, boundary)
            found.append(EdgeInput(variable, nodes, velocity=True, own=own))
    if len(forced_nodes):
        text = "force on each of the `forced_nodes` along x and y"
        variable = Variable("force", "input", "N", (len(forced_nodes), 2), text, start=0.0, axes=("forced_node", "direction"))
        found.append(EdgeInput(variable, np.array(forced_nodes, dtype=np.int64)))
    return found


def _edge_variable(mesh: Mesh, name: str, boundary: Traction | PrescribedVelocity) -> Variable:
    """Return the declaration of an edge's input: one vector, or one vector per node."""
    variable = edge_variable(name, boundary)
    if boundary.along == "edge":
        return variable
    shape, axes = (len(mesh.edge_nodes(name)), 2), (f"{name}_node", "direction")
    order = f"of `mesh.edges.{name}`" if name in mesh.orders else "of x, then y"
    text = f"{variable.description}, for each of its nodes in the order {order}"
    return replace(variable, shape=shape, description=text, axes=axes)


def prescribed_components(mesh: Mesh, boundaries: Mapping[str, Boundary]) -> dict[int, dict[int, str]]:
    """Return the edge that prescribes each component of each node: node -> component -> name of the edge, never empty.

    Raises:
        ParameterError: a symmetry edge does not lie along an axis.
    """
    return shared.prescribed_components(boundaries, mesh.edge_nodes, lambda name, one: _prescribed_axes(mesh, name, one))


def held_edges(
    mesh: Mesh, boundaries: Mapping[str, Boundary], prescribing_edges: Mapping[int, Mapping[int, str]]
) -> dict[str, tuple[IntArray, npt.NDArray[np.bool_]]]:
    """Return for each edge with prescribed motion its nodes, shape (k,), and which components it prescribes, shape (k, 2)."""
    found = {}
    for name, boundary in boundaries.items():
        if isinstance(boundary, (Fixed, PrescribedVelocity, Symmetry)):
            nodes = mesh.edge_nodes(name)
            found[name] = nodes, np.array([[prescribing_edges[node].get(k) == name for k in (0, 1)] for node in nodes.tolist()])
    return found


def _prescribed_axes(mesh: Mesh, name: str, boundary: Boundary) -> tuple[int, ...]:
    if isinstance(boundary, Symmetry):
        nodes = mesh.nodes[mesh.edge_nodes(name)]
        extent = nodes.max(axis=0) - nodes.min(axis=0)
        if extent.min() > _MISFIT * extent.max():
            raise ParameterError("does not lie along x or y, as a symmetry edge must", at=("boundaries", name))
        return (int(np.argmin(extent)),)
    return boundary.prescribed_axes if isinstance(boundary, PrescribedVelocity) else (0, 1)


def dashpot_damping(
    mesh: Mesh, boundaries: Mapping[str, Boundary], density: FloatArray, longitudinal: FloatArray, shear: FloatArray,
    mass: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the damping coefficients xx, yy, xy of each node from absorbing edges and their sponges, shape (n, 3) [N s/m].

    Each side adds half of (rho c_p n n + rho c_s t t) times its length to each of its nodes.

    Args:
        mesh: the mesh.
        boundaries: of the edges.
        density: density of each cell, shape (m,), like the next two arrays [kg/m3].
        longitudinal: speed of P waves [m/s].
        shear: speed of S waves [m/s].
        mass: mass of each node, without nodes joined to it, shape (n,) [kg].
    """
    damping = np.zeros((len(mesh.nodes), 3))
    for name, boundary in boundaries.items():
        if isinstance(boundary, Absorbing):
            sides = mesh.edges[name]
            cell, length = side_cells(mesh, sides), mesh.side_lengths(sides)
            tx, ty = ((mesh.nodes[sides[:, 1]] - mesh.nodes[sides[:, 0]]) / length[:, None]).T
            along, across = 0.5 * density[cell] * shear[cell] * length, 0.5 * density[cell] * longitudinal[cell] * length
            xx, yy = along * tx * tx + across * ty * ty, along * ty * ty + across * tx * tx
            for end in (0, 1):
                np.add.at(damping, sides[:, end], np.stack([xx, yy, (along - across) * tx * ty], axis=1))
            if boundary.sponge_width > 0.0:
                damping[:, :2] += _sponge_damping(mesh, name, boundary, longitudinal, mass)[:, None]
    return damping


def _sponge_damping(mesh: Mesh, name: str, boundary: Absorbing, longitudinal: FloatArray, mass: FloatArray) -> FloatArray:
    """Return the damping coefficient of each node in the layer at an absorbing edge, shape (n,) [N s/m]."""
    from scipy.spatial import cKDTree  # type: ignore[attr-defined]

    width, speed = boundary.sponge_width, np.zeros(len(mesh.nodes))
    for corner in range(4):
        np.maximum.at(speed, mesh.cells[:, corner], longitudinal)
    distance, _ = cKDTree(mesh.nodes[mesh.edge_nodes(name)]).query(mesh.nodes)
    if (distance < width).all():
        raise ParameterError(
            f"got {width:g} m, a layer that contains the whole mesh",
            hint="give a smaller width",
            at=("boundaries", name, "sponge_width"),
        )
    part = np.maximum(1.0 - distance / width, 0.0)
    return boundary.sponge_strength * speed / width * part * part * mass


def absorbing_sides(mesh: Mesh, boundaries: Mapping[str, Boundary]) -> IntArray:
    """Return the two nodes of each side of the absorbing edges, with the body on the left, shape (k, 2)."""
    sides = [mesh.edges[name] for name, boundary in boundaries.items() if isinstance(boundary, Absorbing)]
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *sides])


def side_cells(mesh: Mesh, sides: IntArray) -> IntArray:
    """Return the number of the cell to which each boundary side belongs."""
    n = len(mesh.nodes)
    keys = np.concatenate([mesh.cells[:, j] * n + mesh.cells[:, (j + 1) % 4] for j in range(4)])
    order = np.argsort(keys, kind="stable")
    return order[np.searchsorted(keys[order], sides[:, 0] * n + sides[:, 1])] % len(mesh.cells)


def sum_joined_rows(rows: FloatArray, places: IntArray, groups: IntArray) -> FloatArray:
    """Return values of the nodes with conditions, where each joined node gets the sum over its group.

    Args:
        rows: values of the s nodes with conditions, shape (s, k).
        places: node -> its row, shape (n,).
        groups: groups of nodes that move together, see `joined_nodes`.
    """
    total = rows.copy()
    at_corner = groups[:, 3] >= 0
    pairs, corners = places[groups[~at_corner, :2]], places[groups[at_corner]]
    total[pairs] = (rows[pairs[:, 0]] + rows[pairs[:, 1]])[:, None]
    total[corners] = ((rows[corners[:, 0]] + rows[corners[:, 1]]) + (rows[corners[:, 2]] + rows[corners[:, 3]]))[:, None]
    return total


def leader_rows(
    prescribing_edges: Mapping[int, Mapping[int, str]], places: IntArray, groups: IntArray, count: int
) -> npt.NDArray[np.int64]:
    """Return per node with conditions and component the row of the node whose prescribed velocity it follows, shape (count, 2).

    Joined nodes follow the first member with a prescribed velocity; all other nodes follow themselves.
    """
    leaders = np.repeat(np.arange(count)[:, None], 2, axis=1)
    for group in groups:
        members = group[group >= 0]
        for component in (0, 1):
            own = [node for node in members.tolist() if component in prescribing_edges.get(node, {})]
            if own:
                leaders[places[members], component] = places[own[0]]
    return leaders
