"""Setup of the arrays for kernels from a mesh, its materials and its boundaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..materials.elastic import Material
from ..materials.plastic_law_catalogue import PlasticLaw
from ..support.float_arrays import FloatArray
from . import kernel_arrays, nodal_conditions
from .boundaries import Boundary
from .mesh import IntArray, Mesh
from .nodal_conditions import EdgeInput
from .tiling import make_schedule
from .yielding import law_list


@dataclass(frozen=True)
class Assembly:
    """The arrays for kernels beside the state, and what they were made from.

    Attributes:
        grid: mesh, masses, materials, order of the work.
        conditions: nodes with conditions; without a drive.
        corner: scratch of the kernels.
        mass: of each node by itself, shape (n,) [kg].
        places: node -> its row in `conditions`, -1 for the others, shape (n,).
        joined: groups of nodes that move as one, shape (k, 4), the rest of each row -1.
        leaders: whose prescribed velocity each node with conditions has; see `nodal_conditions.leading_rows`.
        held_edges: nodes and components that edges prescribe; see `nodal_conditions.held_edges`.
        inputs: of the edges, and the forces on nodes.
        absorbing_sides: the two nodes of each side of the absorbing edges, the body on the left, shape (k, 2).
    """

    grid: kernel_arrays.Grid
    conditions: kernel_arrays.Conditions
    corner: FloatArray
    mass: FloatArray
    places: IntArray
    joined: IntArray
    leaders: IntArray
    held_edges: Mapping[str, tuple[IntArray, np.ndarray]]
    inputs: Sequence[EdgeInput]
    absorbing_sides: IntArray


def assemble(
    mesh: Mesh,
    materials: Sequence[Material],
    cell_material: IntArray,
    *,
    laws: Sequence[PlasticLaw],
    boundaries: Mapping[str, Boundary],
    forced: Sequence[int] = (),
    hourglass: float = 1.0,
    parts: int = 1,
    others: Sequence[int] = (),
    attached: FloatArray | None = None,
    pushed: Sequence[int] = (),
) -> Assembly:
    """Return the arrays for a mesh.

    Args:
        mesh: nodes, cells, edges.
        materials: by their number.
        cell_material: the number of each cell, shape (m,).
        laws: plastic law of each material.
        boundaries: of edges by name.
        forced: nodes with the input `force`.
        hourglass: stiffness against hourglass modes, as a part of full integration's.
        parts: parts of the mesh that threads can advance side by side.
        others: nodes that a parent moves: only their forces are written.
        attached: masses of another body that nodes carry too, whose forces a parent adds to those of the cells; nodes that
            carry some become nodes with conditions, shape (n,) [kg].
        pushed: nodes to which a parent adds forces although they carry nothing.

    Raises:
        ParameterError: a boundary does not fit its edge.
    """
    joined = nodal_conditions.joined_nodes(mesh, boundaries)
    prescribed = nodal_conditions.prescribed_components(mesh, boundaries)
    held_edges = nodal_conditions.held_edges(mesh, boundaries, prescribed)
    inputs = nodal_conditions.edge_inputs(mesh, boundaries, forced, held_edges)
    count = len(mesh.nodes)
    density, longitudinal, shear = (
        np.array([getattr(one, name) for one in materials])[cell_material]
        for name in ("density", "longitudinal_speed", "shear_speed")
    )
    own_mass = lump(mesh, density * mesh.areas)
    damped = nodal_conditions.dashpots(mesh, boundaries, density, longitudinal, shear, own_mass)
    plan = make_schedule(count, mesh.cells, parts)
    more = np.zeros(count) if attached is None else attached
    apart = np.concatenate([plan.further[:, 0].astype(np.int64), np.flatnonzero(more), np.array(pushed, np.int64)])
    nodes = nodal_conditions.special_nodes(joined, inputs, prescribed, damped, apart)
    places = np.full(count, -1, dtype=np.int64)
    places[nodes] = np.arange(len(nodes))
    share = own_mass[nodes] / nodal_conditions.join_rows(own_mass[nodes, None], places, joined)[:, 0]
    mass = own_mass + more
    mass[nodes] = nodal_conditions.join_rows(mass[nodes, None], places, joined)[:, 0]
    special = np.zeros(count, dtype=np.uint8)
    special[nodes] = special[np.array(others, dtype=np.int64)] = 1
    moduli = np.array([[one.first_lame, one.shear_modulus] for one in materials])
    grid = kernel_arrays.Grid(
        reference=mesh.nodes,
        cells=mesh.cells.astype(np.uint32),
        mass=mass,
        half_inverse=0.5 / mass,
        material=cell_material.astype(np.uint32),
        moduli=moduli,
        laws=law_list(laws),
        hourglass=hourglass_stiffness(mesh, moduli[cell_material], hourglass),
        slots=plan.slots,
        node_slots=plan.node_slots,
        further=plan.further,
        order=plan.order,
        tiles=plan.tiles,
        parts=plan.parts,
        special=special,
    )
    damping = np.array([damped.get(node, np.zeros(3)) for node in nodes.tolist()]).reshape(-1, 3)
    held = kernel_arrays.Conditions(
        nodes=nodes.astype(np.uint32),
        mass=mass[nodes],
        damping=nodal_conditions.join_rows(damping, places, joined),
        prescribed=_prescribed_flags(prescribed, places, joined, len(nodes)),
        share=share,
        groups=joined.astype(np.int32),
        drive=np.zeros((1, len(nodes), 2)),
        begin=np.zeros((len(nodes), 5, 2)),
    )
    leaders = nodal_conditions.leading_rows(prescribed, places, joined, len(nodes))
    sides = nodal_conditions.absorbing_sides(mesh, boundaries)
    return Assembly(grid, held, np.zeros((plan.rows, 2)), own_mass, places, joined, leaders, held_edges, inputs, sides)


def lump(mesh: Mesh, amounts: FloatArray) -> FloatArray:
    """Return what each node has of amounts of the cells: a quarter of each cell around it, shape (n,)."""
    corners = np.zeros((len(mesh.nodes), 4))
    for corner in range(4):
        np.add.at(corners[:, corner], mesh.cells[:, corner], 0.25 * amounts)
    # In two pairs, so that mirror images have the same bits.
    return (corners[:, 0] + corners[:, 1]) + (corners[:, 2] + corners[:, 3])


def hourglass_stiffness(mesh: Mesh, moduli: FloatArray, part: float) -> FloatArray:
    """Return part (lambda + 3 mu) / 12 of each cell, times (w^2 + h^2) / 2 w h for its width and height, shape (m,) [Pa].

    That is the mean of what full integration gives the two hourglass modes of a rectangle; of a square it is just that.

    Args:
        mesh: nodes and cells.
        moduli: Lame's constants of each cell, shape (m, 2) [Pa].
        part: of full integration's stiffness.
    """
    corners = mesh.nodes[mesh.cells]
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    diagonals = (first * first).sum(axis=1) + (second * second).sum(axis=1)
    return part * (moduli[:, 0] + 3.0 * moduli[:, 1]) / 12.0 * (diagonals / (4.0 * mesh.areas))


def _prescribed_flags(
    prescribed: Mapping[int, Mapping[int, Any]], places: IntArray, joined: IntArray, count: int
) -> np.ndarray:
    flags = np.zeros((count, 2))
    for node, components in prescribed.items():
        flags[places[node], list(components)] = 1.0
    return (nodal_conditions.join_rows(flags, places, joined) > 0.0).astype(np.uint8)
