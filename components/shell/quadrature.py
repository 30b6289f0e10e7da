"""Integration rules: positions and volumes of the points at which stresses are computed.

A rule combines a surface rule with Gauss points through the thickness. The surface rule `column` has one point at each column
of nodes: cheap, but it does not resolve displacements that alternate from column to column, which `hourglass` controls. `cell`
has 2 x 2 Gauss points in each cell between four columns.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ..support.elementary_functions import sine_of_pi
from ..support.float_arrays import FloatArray
from .geometry.axis import Axis, IntArray
from .geometry.lattice import Lattice
from .shape_functions import quartic_spline

RuleName = Literal["column", "cell"]
_NEWTON_STEPS = 10


class LinePoints(NamedTuple):
    """Points along one axis.

    Attributes:
        at: fractional indices of the axis, shape (m,).
        length: length of the axis that each point represents, shape (m,) [m or rad].
    """

    at: FloatArray
    length: FloatArray


class IntegrationPoints(NamedTuple):
    """Points of a body, ordered by columns.

    Attributes:
        lines: the points along each axis; all points are their combinations, except for the heights below a notch.
        heights: fractional index of each point through the thickness, shape (m,).
        volume: volume that each point represents, shape (m,) [m^3].
        sine, cosine: of the angle of the axes at each point to those of the body, shape (m,).
    """

    lines: tuple[LinePoints, LinePoints, LinePoints]
    heights: FloatArray
    volume: FloatArray
    sine: FloatArray
    cosine: FloatArray

    def indices(self, points: IntArray) -> FloatArray:
        """Return the fractional indices of points along the axes, shape (len(points), 3)."""
        along, across, _ = np.unravel_index(points, [len(line.at) for line in self.lines])
        return np.stack([self.lines[0].at[along], self.lines[1].at[across], self.heights[points]], axis=-1)

    def all_indices(self) -> FloatArray:
        """Return the fractional indices of all points, shape (m, 3)."""
        return self.indices(np.arange(len(self.volume)))


def points_at_planes(axis: Axis) -> LinePoints:
    """Return a point at each plane of nodes."""
    return LinePoints(np.arange(axis.count, dtype=np.float64), axis.widths)


def points_in_cells(axis: Axis, radius: float) -> LinePoints:
    """Return two Gauss points between neighbouring planes; the length of each is half a plane times dX/dxi of the functions."""
    cells = axis.count if axis.is_closed else axis.count - 1
    offset, _ = gauss_points(2)
    index = (np.arange(cells)[:, None] + 0.5 + 0.5 * offset).ravel()
    return LinePoints(index, np.array([0.5 * _interpolated_slope(axis, float(one), radius) for one in index]))


def _interpolated_slope(axis: Axis, index: float, radius: float) -> float:
    """Return dX/dxi at an index, from moving least squares along one axis that reproduces linear functions of the index xi."""
    planes = np.array(axis.neighbours(index, radius))
    offset = planes - index
    weight, slope = quartic_spline(-offset / radius)
    slope = slope / radius
    m0, m1, m2 = weight.sum(), (weight * offset).sum(), (weight * offset * offset).sum()
    d0, d1 = slope.sum(), (slope * offset).sum()
    d2, determinant = (slope * offset * offset).sum(), m0 * m2 - m1 * m1
    if not determinant > 0.0:  # too few planes; the stencils refuse this
        return float(axis.slope(np.array([index]))[0])
    # N = (a + b offset) weight, where a and b make the sums of N and of N offset 1 and 0; then their derivatives.
    a, b = m2 / determinant, -m1 / determinant
    first, second = a * d0 + b * d1, a * d1 + b * d2 - 1.0
    change = -(m2 * first - m1 * second) / determinant, (m1 * first - m0 * second) / determinant
    gradient = (a + b * offset) * slope + (change[0] + change[1] * offset) * weight
    return float((gradient * (axis.plane_coordinates(planes) - axis.coordinates(np.array([index])))).sum())


def thickness_points(axis: Axis, count: int, top: int = -1) -> LinePoints:
    """Return Gauss points through the thickness, from the first plane to the last, or to the plane with number `top`."""
    offset, weight = gauss_points(count)
    first, last = axis.positions[0], axis.positions[top]
    place = 0.5 * (first + last) + 0.5 * (last - first) * offset
    index = np.interp(place, axis.positions, np.arange(axis.count, dtype=np.float64))
    return LinePoints(index, 0.5 * (last - first) * weight)


def gauss_points(count: int) -> tuple[FloatArray, FloatArray]:
    """Return Gauss-Legendre points in -1..1, ascending, and their weights: roots of P_n by Newton's iteration."""
    number = np.arange(count, dtype=np.float64)
    x = -sine_of_pi(0.5 - (number + 0.75) / (count + 0.5))
    slope = np.ones(count)
    for _ in range(_NEWTON_STEPS):
        before, value = np.ones(count), x
        for degree in range(2, count + 1):
            before, value = value, ((2 * degree - 1) * x * value - (degree - 1) * before) / degree
        slope = count * (x * value - before) / (x * x - 1.0)
        x = x - value / slope
    weight = 2.0 / ((1.0 - x * x) * slope * slope)
    return 0.5 * (x - x[::-1]), 0.5 * (weight + weight[::-1])


def integration_points(lattice: Lattice, rule: RuleName, thickness_count: int, radius: float) -> IntegrationPoints:
    """Return the points of a rule with `thickness_count` points through the thickness and a support radius [planes]."""
    along, across, thickness = lattice.axes
    first, second = (
        points_at_planes(axis) if rule == "column" else points_in_cells(axis, radius) for axis in (along, across)
    )  # fmt: skip
    lines = first, second, thickness_points(thickness, thickness_count)
    third = thickness_volumes(lattice, lines[2])
    section = lines[0].length[:, None, None] * lines[1].length[:, None]
    volume = section * third
    heights = np.broadcast_to(lines[2].at, volume.shape)
    if lattice.hollow is not None:
        # A point is below the notch if its nearest column is.
        places = np.stack(np.meshgrid(lines[0].at, lines[1].at, indexing="ij"), axis=-1)
        nearest = lattice.nearest_columns(places.reshape(-1, 2))
        below = lattice.hollow.columns.ravel()[nearest].reshape(volume.shape[:2])
        line = thickness_points(thickness, thickness_count, lattice.hollow.bottom)
        volume = np.where(below[..., None], section * thickness_volumes(lattice, line), volume)
        heights = np.where(below[..., None], line.at, heights)
    sine, cosine = lattice.frame_rotation(across.coordinates(lines[1].at))
    shape = volume.shape
    spread = (np.broadcast_to(one[:, None], shape).ravel() for one in (sine, cosine))
    return IntegrationPoints(lines, heights.ravel(), volume.ravel(), *spread)


def thickness_volumes(lattice: Lattice, line: LinePoints) -> FloatArray:
    """Return for points through the thickness the volume per area of the surface coordinates."""
    return line.length * lattice.axes[2].coordinates(line.at) if lattice.bent else line.length
