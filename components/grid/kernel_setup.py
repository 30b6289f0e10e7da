"""Setup of the arrays for kernels from a mesh, its materials and its boundaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..inputs import Held
from ..materials.elastic import Material
from ..materials.plastic_law_catalogue import PlasticLaw
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray
from . import kernel_arrays, nodal_conditions
from .boundaries import Boundary
from .mesh import IntArray, Mesh
from .nodal_conditions import EdgeInput
from .yielding import law_list


@dataclass(frozen=True)
class Assembly:
    """The arrays for kernels except the state, and the tables from which they were built.

    Attributes:
        grid: mesh, masses, materials.
        conditions: nodes with conditions, without a drive.
        corner: scratch of the kernels.
        mass: mass of each node, without nodes joined to it, shape (n,) [kg].
        places: node -> its row in `conditions`, -1 for other nodes, shape (n,).
        joined: groups of nodes that move together, rows padded with -1, shape (k, 4).
        leaders: for each node with conditions, the row of the node whose prescribed velocity it follows; see `leader_rows`.
        held_edges: nodes and components that edges prescribe; see `nodal_conditions.held_edges`.
        inputs: the inputs of the edges, and the forces on nodes.
        absorbing_sides: the two nodes of each side of the absorbing edges, with the body on the left, shape (k, 2).
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


def assemble_grid(
    mesh: Mesh,
    materials: Sequence[Material],
    cell_material: IntArray,
    *,
    laws: Sequence[PlasticLaw],
    boundaries: Mapping[str, Boundary],
    forced_nodes: Sequence[int] = (),
    hourglass: float = 1.0,
    carried_mass: FloatArray | None = None,
    loaded_nodes: Sequence[int] = (),
) -> Assembly:
    """Return the arrays of the kernels for a mesh.

    Args:
        mesh: nodes, cells, edges.
        materials: by their number.
        cell_material: the number of each cell, shape (m,).
        laws: plastic law of each material.
        boundaries: of edges by name.
        forced_nodes: nodes on which the input `force` acts.
        hourglass: stiffness against hourglass modes, as a fraction of that of full integration.
        carried_mass: masses of another body that nodes carry too, shape (n,) [kg]; a parent adds its forces to those of the
            cells. Nodes that carry mass become nodes with conditions.
        loaded_nodes: further nodes, without such mass, to which a parent adds forces.

    Raises:
        ParameterError: a boundary does not fit its edge.
    """
    joined = nodal_conditions.joined_nodes(mesh, boundaries)
    prescribed = nodal_conditions.prescribed_components(mesh, boundaries)
    held_edges = nodal_conditions.held_edges(mesh, boundaries, prescribed)
    inputs = nodal_conditions.edge_inputs(mesh, boundaries, forced_nodes, held_edges)
    count = len(mesh.nodes)
    density, longitudinal, shear = (
        np.array([getattr(one, name) for one in materials])[cell_material]
        for name in ("density", "longitudinal_speed", "shear_speed")
    )
    own_mass = lump_to_nodes(mesh, density * mesh.areas)
    damping = nodal_conditions.dashpot_damping(mesh, boundaries, density, longitudinal, shear, own_mass)
    node_slots, further = _node_corners(count, mesh.cells)
    more = np.zeros(count) if carried_mass is None else carried_mass
    apart = [joined[joined >= 0], *(one.nodes for one in inputs), list(prescribed), np.flatnonzero(damping.any(axis=1))]
    apart += [further[:, 0], np.flatnonzero(more), loaded_nodes]
    nodes = np.unique(np.concatenate([np.array(some, dtype=np.int64) for some in apart]))
    places = np.full(count, -1, dtype=np.int64)
    places[nodes] = np.arange(len(nodes))
    share = own_mass[nodes] / nodal_conditions.sum_joined_rows(own_mass[nodes, None], places, joined)[:, 0]
    mass = own_mass + more
    mass[nodes] = nodal_conditions.sum_joined_rows(mass[nodes, None], places, joined)[:, 0]
    special = np.zeros(count, dtype=np.uint8)
    special[nodes] = 1
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
        node_slots=node_slots.astype(np.uint32),
        further=further.astype(np.uint32),
        special=special,
    )
    held = kernel_arrays.Conditions(
        nodes=nodes.astype(np.uint32),
        mass=mass[nodes],
        damping=nodal_conditions.sum_joined_rows(damping[nodes], places, joined),
        prescribed=_prescribed_flags(prescribed, places, joined, len(nodes)),
        share=share,
        groups=joined.astype(np.int32),
        drive=np.zeros((1, len(nodes), 2)),
        begin=np.zeros((len(nodes), 5, 2)),
    )
    leaders = nodal_conditions.leader_rows(prescribed, places, joined, len(nodes))
    sides = nodal_conditions.absorbing_sides(mesh, boundaries)
    return Assembly(
        grid, held, np.zeros((4 * len(mesh.cells) + 1, 2)), own_mass, places, joined, leaders, held_edges, inputs, sides
    )


def lump_to_nodes(mesh: Mesh, amounts: FloatArray) -> FloatArray:
    """Distribute an amount per cell to nodes, a quarter to each node of the cell; return the sums at the nodes, shape (n,)."""
    corners = np.zeros((len(mesh.nodes), 4))
    for corner in range(4):
        np.add.at(corners[:, corner], mesh.cells[:, corner], 0.25 * amounts)
    # Summed in two pairs of corners, so that mirror images give bitwise equal sums.
    return (corners[:, 0] + corners[:, 1]) + (corners[:, 2] + corners[:, 3])


def hourglass_stiffness(mesh: Mesh, moduli: FloatArray, fraction: float) -> FloatArray:
    """Return fraction x (lambda + 3 mu) / 12 x (w^2 + h^2) / 2 w h for each cell of width w and height h, shape (m,) [Pa].

    For fraction = 1 it is the mean stiffness of the two hourglass modes of a fully integrated rectangle (equal in a square).
    `moduli` are Lame's constants of each cell, shape (m, 2) [Pa].
    """
    corners = mesh.nodes[mesh.cells]
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    diagonals = (first * first).sum(axis=1) + (second * second).sum(axis=1)
    return fraction * (moduli[:, 0] + 3.0 * moduli[:, 1]) / 12.0 * (diagonals / (4.0 * mesh.areas))


def _prescribed_flags(edges: Mapping[int, Mapping[int, Any]], places: IntArray, groups: IntArray, count: int) -> np.ndarray:
    flags = np.zeros((count, 2))
    for node, components in edges.items():
        flags[places[node], list(components)] = 1.0
    return (nodal_conditions.sum_joined_rows(flags, places, groups) > 0.0).astype(np.uint8)


def _node_corners(nodes: int, cells: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rows of the corner forces on each node, one per local corner, shape (nodes, 4), and the (node, row) left over.

    The row 4 m, which belongs to no cell, fills empty entries.
    """
    rows = np.full((nodes, 4), 4 * len(cells), dtype=np.int64)
    beyond = []
    for corner in range(4):
        own = 4 * np.arange(len(cells)) + corner
        who, first = np.unique(cells[:, corner], return_index=True)
        rows[who, corner] = own[first]
        rest = np.ones(len(cells), dtype=bool)
        rest[first] = False
        beyond.append(np.stack([cells[rest, corner], own[rest]], axis=1))
    return rows, np.concatenate(beyond)


def make_drive(
    assembly: Assembly, inputs: Mapping[str, Held], static_force: FloatArray
) -> tuple[list[CompiledProfile], FloatArray]:
    """Return the profiles (functions of time) among the held inputs, and the `drive` of `kernel_arrays.Conditions`.

    The first signal is 1 and carries all constant inputs; the other signals are the profiles.

    Args:
        assembly: the assembly, which contains the nodes with conditions.
        inputs: the held inputs by name.
        static_force: force on each side of the absorbing edges, half of it on each of its nodes, shape (k, 2) [N].
    """
    values = [inputs[one.variable.name] for one in assembly.inputs]
    profiles = [value for value in values if isinstance(value, CompiledProfile)]
    forces = np.zeros((1 + len(profiles), len(assembly.conditions.nodes), 2))
    velocities = np.zeros_like(forces)
    for end in (0, 1):
        np.add.at(forces[0], assembly.places[assembly.absorbing_sides[:, end]], 0.5 * static_force)
    signal = 0
    for one, value in zip(assembly.inputs, values, strict=True):
        profile = isinstance(value, CompiledProfile)
        signal += profile
        target, row = velocities if one.velocity else forces, signal if profile else 0
        target[row, assembly.places[one.nodes]] += one.nodal_values(value.pattern if profile else value)
    flags = assembly.conditions.prescribed > 0
    for row in range(len(forces)):
        led = np.take_along_axis(velocities[row], assembly.leaders, axis=0)
        forces[row] = np.where(flags, led, nodal_conditions.sum_joined_rows(forces[row], assembly.places, assembly.joined))
    return profiles, forces


def mean_signals(profiles: list[CompiledProfile], tick: int, ticks: int) -> FloatArray:
    """Return the means of signals over each of `ticks` ticks from `tick` on, shape (ticks, 1 + profiles); the first is 1."""
    factors = np.ones((ticks, 1 + len(profiles)))
    for place, profile in enumerate(profiles):
        factors[:, 1 + place] = profile.mean_factors(tick, ticks)
    return factors
