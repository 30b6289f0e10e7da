"""Setup of the arrays for kernels from the parameters of a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..support.float_arrays import FloatArray
from .boundaries import Conditions, edge_nodes, make_conditions
from .geometry.lattice import Lattice, column_neighbours
from .hourglass import make_hourglass
from .kernel_arrays import IndexArray, IntArray, Nodes, Points, Solid, Surface
from .parameters import ShellParameters
from .quadrature import IntegrationPoints, integration_points, points_at_planes
from .shape_functions import UnspannedBasisError
from .stencils import Stencils, make_stencils
from .zero_modes import RIGID_MOTIONS, zero_mode_count

# A combination of layers, rule, points through the thickness, basis and radius that is known to have no zero-energy modes.
_KNOWN = (3, "column", 2, "linear", 1.7)


class Gauge(NamedTuple):
    """A strain gauge at a node of the outer surface.

    Attributes:
        neighbours: neighbours of the node, shape (k,).
        gradients: gradients of their shape functions along the axes at the node, shape (k, 3) [1/m].
        along: factor by which gradients along the body are multiplied, see `Stencils`.
        directions: unit vectors along the body, and across or around it, shape (2, 3).
    """

    neighbours: IndexArray
    gradients: FloatArray
    along: float
    directions: FloatArray


@dataclass(frozen=True, eq=False)
class Assembly:
    """The tables that a component builds once; components with equal bodies share them. They are read-only.

    Attributes:
        lattice: the nodes.
        points: the integration points.
        stencils: stencils of the points.
        node_stencils: stencils of the nodes themselves, for reading fields; without gradients.
        gauges: strain gauges.
        solid: the tables of the kernels, without step and wall.
        conditions: the prescribed velocities.
    """

    lattice: Lattice
    points: IntegrationPoints
    stencils: Stencils
    node_stencils: Stencils
    gauges: list[Gauge]
    solid: Solid
    conditions: Conditions

    def coordinates(self, point: int) -> list[float]:
        """Return the initial position of an integration point: x, y, z [m], or x [m], angle [rad], radius [m]."""
        return [
            float(axis.coordinates(one))
            for axis, one in zip(self.lattice.axes, self.points.indices(np.array([point]))[0], strict=True)
        ]

    def describe_position(self, point: int) -> str:
        """Return a text with the initial position of an integration point."""
        return self.lattice.describe_position(self.coordinates(point))


# The parameters that determine the tables of a body; and the assemblies in use, by the values of these parameters.
_SOURCES = ("body", "material", "boundaries", "basis", "radius", "integration", "hourglass", "gauges")
_in_use: WeakValueDictionary[str, Assembly] = WeakValueDictionary()


def assemble_solid(p: ShellParameters) -> Assembly:
    """Return the tables of a body; components with equal bodies share them, e.g. a tube and the component that finds its step.

    Raises:
        ParameterError: the rule has zero-energy modes, or the neighbours of a point do not span the basis.
    """
    key = repr([getattr(p, name) for name in _SOURCES])
    found = _in_use.get(key)
    if found is None:
        found = _in_use[key] = _build_assembly(p)
    return found


def _build_assembly(p: ShellParameters) -> Assembly:
    refuse_zero_energy_modes(p)
    lattice, rule, radius = p.body.lattice(), p.integration_rule, p.chosen_radius
    points = integration_points(lattice, rule.surface, rule.through, radius)
    along, across, through = lattice.axes
    lines = points_at_planes(along), points_at_planes(across), points_at_planes(through)
    try:
        stencils = make_stencils(lattice, points.lines, radius, p.basis, points.all_indices())
        node_stencils = make_stencils(lattice, lines, radius, p.basis, lattice.indices(np.arange(lattice.node_count)))
    except UnspannedBasisError as error:
        why = str(error)
        if error.place:
            why = f"the point at {lattice.describe_position(error.place)} has too few neighbours for the basis {p.basis!r}"
        raise ParameterError(
            f"got {radius:g} spacings: {why}", expected="a radius that contains enough nodes",
            hint="give a larger radius, or more nodes", at="body" if p.radius is None else "radius",
        ) from None  # fmt: skip
    conditions = make_conditions(p.body, lattice, p.boundaries)
    alpha = p.hourglass if rule.surface == "column" else 0.0
    solid = Solid(
        points=Points(
            *stencils[:4], stencils.gradients, stencils.along, points.volume, points.sine, points.cosine
        ),
        nodes=Nodes(
            p.material.density * lattice.volumes, conditions.prescribed, *transpose_stencils(stencils, lattice.node_count)
        ),
        hourglass=make_hourglass(lattice, rule.through, p.material.young, alpha), surface=inner_surface(lattice),
        law=p.material.constants(1.0), plastic=False, step=1.0, wall=np.zeros(2), bounce=np.zeros(0), reference=lattice.nodes,
    )  # fmt: skip
    gauges = [_make_gauge(lattice, node_stencils, column) for column in gauge_columns(p, lattice)]
    return Assembly(lattice, points, stencils, node_stencils.drop_gradients(), gauges, solid, conditions)


def refuse_zero_energy_modes(p: ShellParameters) -> None:
    """Raise `ParameterError` if the integration rule has zero-energy modes in addition to rigid motions."""
    rule = p.integration_rule
    chosen = (p.body.node_counts[2], rule.surface, rule.through, p.basis, p.chosen_radius)
    if chosen == _KNOWN:
        return
    try:
        modes = zero_mode_count(*chosen)
    except UnspannedBasisError:  # the stencils of the body report the point
        return
    if modes != RIGID_MOTIONS:
        raise ParameterError(
            f"got {rule.surface!r} with {rule.through} points through {p.body.node_counts[2]} layers, basis {p.basis!r}, "
            f"radius {p.chosen_radius:g}: a free patch has {modes} zero-energy modes",
            expected=f"{RIGID_MOTIONS}, the rigid motions only",
            hint="use more points, or surface = 'cell'", at="integration",
        )  # fmt: skip


def transpose_stencils(stencils: Stencils, nodes: int) -> tuple[IndexArray, IndexArray, npt.NDArray[np.uint16]]:
    """Return the points of each node from the nodes of each point: `begin`, `points` and `slot` of `kernel_arrays.Nodes`."""
    begin, seen = stencils.begin.astype(np.int64), stencils.nodes
    order = np.argsort(seen, kind="stable")
    point = np.repeat(np.arange(len(begin) - 1, dtype=np.uint32), np.diff(begin))[order]
    ends = np.concatenate([[0], np.cumsum(np.bincount(seen, minlength=nodes))]).astype(np.uint32)
    return ends, point, (order - begin[point]).astype(np.uint16)


def inner_surface(lattice: Lattice) -> Surface:
    """Return the surface under pressure: the inner one of a tube, the lower one of a plate."""
    n, m, _ = lattice.shape
    nodes = edge_nodes(lattice, "bottom")
    around = column_neighbours(n, m, lattice.axes[1].is_closed).astype(np.int32)
    return Surface(nodes, np.repeat(np.arange(n), m), around, lattice.nodes[nodes])


def surface_quads(lattice: Lattice) -> IntArray:
    """Return the four columns of each cell of the surface, in cyclic order, shape (cells, 4)."""
    n, m, _ = lattice.shape
    rows = m if lattice.axes[1].is_closed else m - 1
    along, across = (one.ravel() for one in np.meshgrid(np.arange(n - 1), np.arange(rows), indexing="ij"))
    after = (across + 1) % m
    quads = (along * m + across, (along + 1) * m + across, (along + 1) * m + after, along * m + after)
    return np.stack(quads, axis=1)


def station_means(assembly: Assembly, values: FloatArray) -> FloatArray:
    """Return the volume-weighted mean of a field of the points over each row of points around the body, shape (rows,)."""
    volume = assembly.points.volume.reshape(len(assembly.points.lines[0].at), -1)
    return np.asarray((values.reshape(volume.shape) * volume).sum(axis=1) / volume.sum(axis=1), dtype=np.float64)


def gauge_columns(p: ShellParameters, lattice: Lattice) -> list[int]:
    """Return the column nearest to each gauge.

    Raises:
        ParameterError: a gauge does not lie on the body.
    """
    found = []
    for number, place in enumerate(p.gauges):
        indices = []
        for axis, value, unit in zip(lattice.axes[:2], place, ("m", "rad" if lattice.bent else "m"), strict=True):
            if not 0.0 <= value <= axis.length:
                expected = f"0 to {axis.length:g} {unit}"
                raise ParameterError(f"got {value:g} {unit}", expected=expected, at=("gauges", number, len(indices)))
            distance: FloatArray = np.abs(axis.positions - value)
            if axis.is_closed:
                distance = np.minimum(distance, axis.period - distance)
            indices.append(int(distance.argmin()))
        found.append(indices[0] * lattice.shape[1] + indices[1])
    return found


def _make_gauge(lattice: Lattice, stencils: Stencils, column: int) -> Gauge:
    node = int(lattice.top_nodes[column])
    place = column % lattice.shape[1]
    (sine,), (cosine,) = lattice.frame_rotation(lattice.axes[1].positions[place : place + 1])
    directions = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine]])
    return Gauge(stencils.neighbours(node), stencils.point_gradients(node).copy(), float(stencils.along[node]), directions)
