"""Stencils: the neighbouring nodes of each point and their weights, shared by points with equal neighbourhoods.

Along its own axes (along, around, through the wall) a point of an even tube has the same neighbourhood as all points in its
row: the gradients of the shape functions are stored once per kind of neighbourhood, and rotated by the angle of the point. If
distances grow uniformly along the body, neighbourhoods differ only in length, and their gradients along it are scaled.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from .geometry.axis import Axis, IntArray
from .geometry.lattice import Lattice
from .kernel_arrays import IndexArray
from .quadrature import LinePoints
from .shape_functions import BasisName, UnspannedBasisError, moving_least_squares, quartic_spline


class Stencils(NamedTuple):
    """Neighbours of m points, and their shape functions; s kinds of neighbourhood.

    Attributes:
        begin: start of the neighbours of each point in `nodes`, and the end of the last one, shape (m + 1,).
        nodes: the neighbours, shape (entries,).
        kind: number of each point's stencil, shape (m,).
        first: start of each stencil in the two tables, and the end of the last one, shape (s + 1,).
        values: shape functions, shape (rows,).
        gradients: their gradients along the axes at the point, shape (rows, 3) [1/m].
        along: factor by which gradients along the body are multiplied, shape (m,): spacing at the point of the stored stencil
            over the spacing at the point itself.
    """

    begin: IndexArray
    nodes: IndexArray
    kind: IndexArray
    first: IndexArray
    values: FloatArray
    gradients: FloatArray
    along: FloatArray

    def neighbours(self, point: int) -> IndexArray:
        """Return the neighbours of a point."""
        return self.nodes[self.begin[point] : self.begin[point + 1]]

    def neighbour_counts(self, points: IntArray) -> IntArray:
        """Return the number of neighbours of some points."""
        return self.begin[points + 1].astype(np.int64) - self.begin[points]

    def point_gradients(self, point: int) -> FloatArray:
        """Return the gradients of the shape functions of a point's neighbours, rows of `gradients`, shape (neighbours, 3)."""
        first, end = self.first[self.kind[point] :][:2]
        return self.gradients[first:end]

    def drop_gradients(self) -> Stencils:
        """Return the stencils without gradients, which take most of the memory, and without the factors `along`."""
        return self._replace(gradients=np.zeros((0, 3)), along=np.zeros(0))


# Two spacings count as equal if they differ by less than this fraction, i.e. by rounding errors.
_SAME = 1e-12
_Marks = npt.NDArray[np.bool_]


class _LineStencils(NamedTuple):
    """The neighbouring planes of points along one axis; at most k.

    Attributes:
        planes: neighbouring planes of each point, shape (m, k); padded with copies of the first.
        present: whether an entry of `planes` is a neighbour, not padding, shape (m, k).
        kinds: number of the kind of neighbourhood of each point, shape (m,).
        kept: a representative point of each kind, shape (kinds,).
        at: fractional indices of the points, shape (m,).
        stretch: spacing at the representative point over the spacing at each point, shape (m,).
    """

    planes: IntArray
    present: npt.NDArray[np.bool_]
    kinds: IntArray
    kept: IntArray
    at: FloatArray
    stretch: FloatArray


def _make_line_stencils(axis: Axis, index: FloatArray, radius: float, is_shared: bool, is_scaled: bool) -> _LineStencils:
    found = [axis.neighbours(float(one), radius) for one in index]
    for point, some in enumerate(found):
        if not some:
            message = f"a point has too few neighbours: none lies within {radius:g} spacings along one of the axes"
            raise UnspannedBasisError(point, message)
    most = max(map(len, found))
    planes = np.array([[*some, *[some[0]] * (most - len(some))] for some in found], dtype=np.int64)
    present = np.array([[number < len(some) for number in range(most)] for some in found])
    # Points with equal relative positions of planes, to rounding, are of one kind; if the axis may be scaled, also if these
    # differ by a factor. Through the thickness of a bent body no two points have equal neighbourhoods.
    slope = axis.slope(index)
    scale = slope[:, None] if is_scaled else float(np.abs(slope).min())
    seen = np.concatenate([axis.plane_coordinates(planes) - axis.coordinates(index)[:, None], slope[:, None]], axis=1)
    rounded = np.rint(np.concatenate([seen / scale, planes - index[:, None], present], axis=1) * 1e9)
    if not is_shared:
        rounded = np.concatenate([rounded, np.arange(len(index))[:, None]], axis=1)
    _, kept, kinds = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    stretch = slope[kept[kinds.ravel()]] / slope
    stretch = np.where(np.abs(stretch - 1.0) < _SAME, 1.0, stretch)
    return _LineStencils(planes, present, kinds.ravel(), kept, index, stretch)


def make_stencils(
    lattice: Lattice, lines: tuple[LinePoints, LinePoints, LinePoints], radius: float, basis: BasisName,
    places: FloatArray | None = None,
) -> Stencils:  # fmt: skip
    """Return the stencils of points that are all combinations of points along the axes, except those at a notch.

    Args:
        lattice: the nodes.
        lines: points along each axis.
        radius: support radius of a point along each axis, in spacings.
        basis: of the shape functions.
        places: positions of the points, shape (m, 3), if a notch makes them differ from the combinations.

    Raises:
        UnspannedBasisError: the neighbours of a point do not span the basis.
    """
    even = _product_stencils(lattice, lines, radius, basis)
    if lattice.hollow is None:
        return even
    product = np.stack(np.meshgrid(*(line.at for line in lines), indexing="ij"), axis=-1).reshape(-1, 3)
    places = product if places is None else places
    below = np.repeat(lattice.hollow.columns.ravel(), lattice.shape[2])
    near = np.logical_or.reduceat(below[even.nodes], even.begin[:-1])
    picked = np.flatnonzero(near | (places != product).any(axis=1))
    return _replace_stencils(even, picked, *_individual_stencils(lattice, places[picked], radius, basis))


def _replace_stencils(
    stencils: Stencils, point_numbers: IntArray, nodes: IntArray, is_valid: _Marks, values: FloatArray, gradients: FloatArray
) -> Stencils:
    """Return stencils in which some points have individual stencils, given by the last four arguments."""
    counts, own = np.diff(stencils.begin.astype(np.int64)), is_valid.sum(axis=1)
    is_own = np.zeros(len(counts), dtype=bool)
    is_own[point_numbers] = True
    kept = stencils.nodes[np.repeat(~is_own, counts)]
    counts[point_numbers] = own
    mixed = np.empty(counts.sum(), dtype=np.uint32)
    entries = np.repeat(is_own, counts)
    mixed[~entries], mixed[entries] = kept, nodes[is_valid]
    kind = stencils.kind.copy()
    kind[point_numbers] = len(stencils.first) - 1 + np.arange(len(point_numbers))
    first = np.concatenate([stencils.first[:-1], stencils.first[-1] + _row_starts(own)]).astype(np.uint32)
    values, gradients = np.concatenate([stencils.values, values]), np.concatenate([stencils.gradients, gradients])
    begin = _row_starts(counts)
    return Stencils(begin, mixed, kind, first, values, gradients, np.where(is_own, 1.0, stencils.along))


def _individual_stencils(
    lattice: Lattice, places: FloatArray, radius: float, basis: BasisName
) -> tuple[IntArray, _Marks, FloatArray, FloatArray]:
    """Return the neighbours of arbitrary points, which entries are valid, (m, k), and their shape functions and gradients.

    Below a notch the radius through the wall is shorter, see `Lattice.support_radius`.
    """
    planes, near = [], []
    for axis, place in zip(lattice.axes[:2], places.T[:2], strict=True):
        some = np.ceil(place - radius).astype(np.int64)[:, None] + np.arange(int(2.0 * radius) + 2)
        there = np.abs(some - place[:, None]) < radius
        near.append(there if axis.is_closed else there & (some >= 0) & (some < axis.count))
        planes.append(np.clip(some, 0, axis.count - 1) if not axis.is_closed else some)
    layers = np.broadcast_to(np.arange(lattice.shape[2]), (len(places), lattice.shape[2]))
    along, across, layer = _expand_axis_arrays([*planes, layers])
    nodes = lattice.node_numbers(along, across, layer)
    seen = [along, across, lattice.heights(nodes)]
    marks = _expand_axis_arrays([*near, np.ones_like(layers, dtype=bool)])
    reach = lattice.support_radius(places, radius)[:, None]
    present = marks[0] & marks[1] & (np.abs(seen[2] - places[:, 2, None]) < reach)
    own = [places[:, axis, None] for axis in range(3)]
    values, gradients = _least_squares_functions(lattice, own, seen, present, (radius, radius, reach), basis)
    return nodes, present, values[present], gradients[present]


def _expand_axis_arrays(lines: list[Any]) -> list[Any]:
    """Return for each point all combinations of its values along the three axes: three arrays of shape (m, k)."""
    shape = (len(lines[0]), *(line.shape[1] for line in lines))
    forms = ((slice(None), slice(None), None, None), (slice(None), None, slice(None), None), (slice(None), None, None))
    return [np.broadcast_to(line[form], shape).reshape(shape[0], -1) for line, form in zip(lines, forms, strict=True)]


def _least_squares_functions(
    lattice: Lattice,
    point_indices: list[FloatArray],
    neighbour_indices: list[Any],
    is_valid: _Marks,
    radii: tuple[float, float, float | FloatArray],
    basis: BasisName,
) -> tuple[FloatArray, FloatArray]:
    """Return shape functions (m, k) and their gradients (m, k, 3) [1/m] of arbitrary points.

    The functions reproduce the basis in coordinates. Their gradients are those of functions that reproduce it in plane indices,
    dN/dX = (dN/dxi) (dX/dxi)^-1. For unevenly spaced planes both give exact gradients of linear fields, but only the latter
    leave no force on interior nodes under constant stress.

    Args:
        lattice: the nodes.
        point_indices: indices of the points along each axis, each of shape (m, 1).
        neighbour_indices: indices of the neighbours along each axis, counted on beyond a seam, fractional through the
            thickness, each of shape (m, k).
        is_valid: mask of valid neighbours, shape (m, k).
        radii: support radii along each axis, in planes; the third may differ per point, shape (m, 1).
        basis: of the shape functions.

    Raises:
        UnspannedBasisError: the neighbours of a point do not span the basis; the error names its position.
    """
    offsets, weights, slopes = point_weights(lattice, point_indices, neighbour_indices, is_valid, radii)
    at_point = [axis.coordinates(one) for axis, one in zip(lattice.axes, point_indices, strict=True)]
    even = [at_point[k] + lattice.axes[k].slope(point_indices[k]) * (neighbour_indices[k] - point_indices[k]) for k in range(2)]
    by_index = local_offsets(lattice, [*even, lattice.axes[2].coordinates(neighbour_indices[2])], at_point)
    try:
        values, _ = moving_least_squares(offsets.swapaxes(0, 1), weights.T, slopes.swapaxes(0, 1), basis)
        _, gradients = moving_least_squares(by_index.swapaxes(0, 1), weights.T, slopes.swapaxes(0, 1), basis)
    except UnspannedBasisError as error:
        place = tuple(float(one[error.point, 0]) for one in at_point)
        raise UnspannedBasisError(error.point, str(error), place) from None
    # Offsets are in units of the support's extent along each axis: distances may differ by many powers of ten.
    reach = np.abs(offsets).max(axis=1, keepdims=True)
    offsets, gradients = offsets / reach, gradients.swapaxes(0, 1) * reach
    # Derivatives of the coordinates i with respect to the evenly spaced coordinates j; gradients are divided by them.
    stretch = [[(offsets[..., i] * gradients[..., j]).sum(axis=1) for j in range(3)] for i in range(3)]
    return values.T, _divide_by_matrices(gradients, stretch) / reach


def _divide_by_matrices(gradients: FloatArray, stretch: list[list[FloatArray]]) -> FloatArray:
    """Return gradients (m, k, 3) times the inverses of 3 x 3 matrices, whose entries have the shape (m,)."""
    a, b, c = stretch
    minors = [
        [(p[1] * q[2] - p[2] * q[1]), (p[2] * q[0] - p[0] * q[2]), (p[0] * q[1] - p[1] * q[0])]
        for p, q in ((b, c), (c, a), (a, b))
    ]
    volume = a[0] * minors[0][0] + a[1] * minors[0][1] + a[2] * minors[0][2]
    volume = np.where(np.abs(volume) > _SAME, volume, 1.0)  # on the axis of a tube there is no direction around it
    return np.stack([sum(gradients[..., j] * (minors[i][j] / volume)[:, None] for j in range(3)) for i in range(3)], axis=-1)


def _product_stencils(
    lattice: Lattice, lines: tuple[LinePoints, LinePoints, LinePoints], radius: float, basis: BasisName
) -> Stencils:
    """Return the stencils of points that are all combinations of points along the axes, as if all nodes existed."""
    rows = [
        _make_line_stencils(axis, line.at, radius, not (lattice.bent and place == 2), place == 0)
        for place, (axis, line) in enumerate(zip(lattice.axes, lines, strict=True))
    ]
    # For each kind, a representative point: the combination of representative points along the axes.
    picks = [one.ravel() for one in np.meshgrid(*(row.kept for row in rows), indexing="ij")]
    pairs = list(zip(rows, picks, strict=True))
    own, seen = [row.at[pick][:, None] for row, pick in pairs], _expand_axis_arrays([row.planes[pick] for row, pick in pairs])
    present = np.logical_and.reduce(_expand_axis_arrays([row.present[pick] for row, pick in pairs]))
    values, gradients = _least_squares_functions(lattice, own, seen, present, (radius, radius, radius), basis)
    kinds = np.meshgrid(*(row.kinds for row in rows), indexing="ij")
    kind = np.ravel_multi_index(kinds, [len(row.kept) for row in rows]).ravel()
    nodes, there = _neighbours(lattice, rows)
    begin = _row_starts(there.sum(axis=1))
    return Stencils(
        begin, nodes[there], kind.astype(np.uint32), _row_starts(present.sum(axis=1)), values[present],
        gradients[present], np.repeat(rows[0].stretch, len(kind) // len(rows[0].stretch)),
    )  # fmt: skip


def _row_starts(counts: IntArray) -> npt.NDArray[np.uint32]:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.uint32)


def _neighbours(lattice: Lattice, rows: Sequence[_LineStencils]) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.bool_]]:
    """Return the neighbours of all points, and a mask of the valid ones, shape (m, k).

    The number of a node is the sum of one number per axis. Indices of neighbours are not stored, because they would take most
    of the memory during the build.
    """
    _, across, layers = lattice.shape
    along, around, through = rows
    parts = (along.planes * (across * layers), around.planes % across * layers, through.planes)
    nodes = _product_values([one.astype(np.uint32) for one in parts], np.add)
    return nodes, _product_values([row.present for row in rows], np.logical_and)


def _product_values(axis_values: list[npt.NDArray[Any]], operation: np.ufunc) -> npt.NDArray[Any]:
    """Return for all combinations of points along the axes their three values, joined by `operation`, shape (m, k)."""
    first, second, third = axis_values
    plane = operation(second[:, None, :, None], third[None, :, None, :])
    joined = operation(first[:, None, None, :, None, None], plane[None, :, :, None])
    return joined.reshape(len(first) * len(second) * len(third), -1)


def point_weights(
    lattice: Lattice,
    point_indices: list[FloatArray],
    neighbour_indices: list[Any],
    is_valid: _Marks,
    radii: tuple[float, float, float | FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return offsets (m, k, 3), weights (m, k) and gradients of the weights (m, k, 3) of points at `point_indices` (m, 1).

    The arguments are as in `_least_squares_functions`.
    """
    parts = [quartic_spline((point_indices[k] - neighbour_indices[k]) / radii[k]) for k in range(3)]
    there = is_valid.astype(np.float64)
    weights = parts[0][0] * parts[1][0] * parts[2][0] * there
    by_index = [parts[k][1] * parts[(k + 1) % 3][0] * parts[(k + 2) % 3][0] * there / radii[k] for k in range(3)]
    stretch = [axis.slope(one) for axis, one in zip(lattice.axes, point_indices, strict=True)]
    along, across, through = lattice.axes
    at_planes = [
        along.plane_coordinates(neighbour_indices[0]),
        across.plane_coordinates(neighbour_indices[1]),
        through.coordinates(neighbour_indices[2]),
    ]
    at_point = [axis.coordinates(one) for axis, one in zip(lattice.axes, point_indices, strict=True)]
    if lattice.bent:
        stretch[1] = stretch[1] * at_point[2]
    offsets = local_offsets(lattice, at_planes, at_point)
    slopes = np.stack([one / length for one, length in zip(by_index, stretch, strict=True)], axis=-1)
    return offsets, weights, slopes


def local_offsets(lattice: Lattice, nodes: list[FloatArray], points: list[FloatArray]) -> FloatArray:
    """Return the positions of nodes relative to the points of which they are neighbours, along the points' axes, (m, k, 3) [m].

    Args:
        lattice: straight or bent.
        nodes: coordinates of the nodes along each axis, shape (m, k).
        points: coordinates of the points, shape (m, 1).
    """
    along = nodes[0] - points[0]
    if not lattice.bent:
        return np.stack([along, nodes[1] - points[1], nodes[2] - points[2]], axis=-1)
    sine, cosine = lattice.frame_rotation(nodes[1] - points[1])
    return np.stack([along, nodes[2] * sine, nodes[2] * cosine - points[2]], axis=-1)
