"""A body as a lattice of nodes: planes along three directions, straight or bent around the x axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...support.elementary_functions import sine_of_pi
from ...support.float_arrays import FloatArray
from .axis import Axis, IntArray


class Hollow(NamedTuple):
    """The part of a lattice that a notch removes. A column is a row of nodes through the wall.

    Columns below a notch have the same number of nodes as all others, closer together: with two planes of nodes a ligament
    could not get thinner on one side alone, and would lock under plastic flow.

    Attributes:
        columns: whether a column of nodes ends at the bottom of the notch, shape (along, across).
        bottom: number of the plane of nodes through the thickness at the bottom.
    """

    columns: npt.NDArray[np.bool_]
    bottom: int

    def layer_step(self, layers: int) -> float:
        """Return the distance of nodes in columns below the notch, in planes of the lattice; columns have `layers` nodes."""
        return self.bottom / (layers - 1)


@dataclass(frozen=True)
class Lattice:
    """Nodes in rows along the body, across (or around) it, and through its thickness; the last index runs fastest.

    The coordinates along the axes of a straight body are x, y, z. For a bent body they are x, an angle t and a radius r, and a
    node is at (x, r sin t, r cos t).

    Attributes:
        axes: along, across or around, through the thickness.
        bent: whether the second axis is an angle [rad] and the third one a radius.
        hollow: the part that a notch removes; the nodes of its columns lie in the ligament below it.
    """

    axes: tuple[Axis, Axis, Axis]
    bent: bool
    hollow: Hollow | None = None

    def describe_position(self, place: Sequence[float]) -> str:
        """Return a text with the coordinates of a place along the axes, their names and units."""
        x, y, z = place
        if self.bent:
            return f"x = {x:.4g} m, angle {y:.3g} rad, radius {z:.4g} m"
        return f"x, y, z = {x:.4g}, {y:.4g}, {z:.4g} m"

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of nodes along each axis."""
        return self.axes[0].count, self.axes[1].count, self.axes[2].count

    @property
    def node_count(self) -> int:
        """Number of all nodes."""
        return self.shape[0] * self.shape[1] * self.shape[2]

    @cached_property
    def nodes(self) -> FloatArray:
        """Positions of the nodes, shape (n, 3) [m]."""
        along, across, through = np.meshgrid(*(axis.positions for axis in self.axes), indexing="ij")
        if self.hollow is not None:
            through = self.axes[2].coordinates(self.heights(np.arange(self.node_count)))
        return self.positions(along.ravel(), across.ravel(), through.ravel())

    @property
    def volumes(self) -> FloatArray:
        """Volume that each node represents, shape (n,) [m^3]."""
        along, across, _ = (axis.widths for axis in self.axes)
        through = self._thickness_weights(self.axes[2].bounds)
        volumes = along[:, None, None] * across[:, None] * through
        if self.hollow is not None:
            planes = self.hollow.layer_step(self.shape[2]) * np.arange(self.shape[2], dtype=np.float64)
            left = self._thickness_weights(Axis(self.axes[2].coordinates(planes)).bounds)
            volumes = np.where(self.hollow.columns[..., None], along[:, None, None] * across[:, None] * left, volumes)
        return volumes.ravel()

    def _thickness_weights(self, bounds: FloatArray) -> FloatArray:
        return 0.5 * np.diff(bounds * bounds) if self.bent else np.diff(bounds)

    @cached_property
    def layer_steps(self) -> FloatArray:
        """Distance of the nodes of each column through the thickness, in planes: 1, or less below a notch, shape (columns,)."""
        steps = np.ones(self.shape[:2])
        if self.hollow is not None:
            steps[self.hollow.columns] = self.hollow.layer_step(self.shape[2])
        return steps.ravel()

    def indices(self, nodes: IntArray) -> FloatArray:
        """Return the indices of nodes along the axes, shape (len(nodes), 3); fractional only below a notch."""
        places = np.stack(np.unravel_index(nodes, self.shape), axis=-1).astype(np.float64)
        places[:, 2] = self.heights(nodes)
        return places

    def support_radius(self, index: FloatArray, radius: float) -> FloatArray:
        """Return the support radius of points through the thickness, shape (m,) [planes].

        Below a notch nodes are close in the column of the point and distant in the next one; a mean distance is used.

        Args:
            index: fractional indices of the points, shape (m, 3).
            radius: support radius in node distances; the geometric mean of both distances is used.
        """
        return radius * np.sqrt(self.layer_steps[self.nearest_columns(index)])

    def nearest_columns(self, index: FloatArray) -> IntArray:
        """Return the number of the column nearest to each point, of fractional indices of shape (m, 3)."""
        n, m, _ = self.shape
        nearest = np.rint(index[:, :2]).astype(np.int64)
        return np.minimum(nearest[:, 0], n - 1) * m + nearest[:, 1] % m

    def heights(self, nodes: IntArray) -> FloatArray:
        """Return the fractional indices of nodes through the thickness, as in `indices`."""
        layers = self.shape[2]
        return nodes % layers * self.layer_steps[nodes // layers]

    @property
    def top_nodes(self) -> IntArray:
        """The outermost node of each column, shape (columns,)."""
        return np.arange(self.shape[2] - 1, self.node_count, self.shape[2])

    def positions(self, along: FloatArray, across: FloatArray, through: FloatArray) -> FloatArray:
        """Return the positions of points with given coordinates along the axes, shape (m, 3) [m]."""
        if not self.bent:
            return np.stack([along, across, through], axis=-1)
        sine, cosine = self.frame_rotation(across)
        return np.stack([along, through * sine, through * cosine], axis=-1)

    def frame_rotation(self, across: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return sine and cosine of the angle by which the frame of a point is rotated about -x; 0, 1 for a straight body."""
        if not self.bent:
            return np.zeros_like(across), np.ones_like(across)
        return sine_of_pi(across / np.pi), sine_of_pi(0.5 - across / np.pi)

    def node_numbers(self, along: IntArray, across: IntArray, through: IntArray) -> IntArray:
        """Return the numbers of nodes from their indices, which may continue beyond the seam of a closed axis."""
        _, m, k = self.shape
        return (along * m + across % m) * k + through


def column_neighbours(n: int, m: int, is_closed: bool) -> IntArray:
    """Return the columns before and after each one along and across, itself if there is none, shape (n m, 4).

    There are n columns along and m across. If `is_closed`, the first one across follows the last one.
    """
    along, across = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    before, after = np.maximum(along - 1, 0), np.minimum(along + 1, n - 1)
    left, right = across - 1, across + 1
    left, right = (left % m, right % m) if is_closed else (np.maximum(left, 0), np.minimum(right, m - 1))
    found = (before * m + across, after * m + across, along * m + left, along * m + right)
    return np.stack([one.ravel() for one in found], axis=1)
