"""A body as a lattice of nodes: planes along three directions, straight or bent around the x axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...support.arrays import FloatArray
from ...support.elementary import sine_of_pi
from .axis import Axis, IntArray
from .notch import Hollow


@dataclass(frozen=True)
class Lattice:
    """Nodes in rows along the body, across (or around) it, and through its thickness; the last index runs fastest.

    Of a straight body the coordinates of the axes are x, y, z. Of a bent one they are x, an angle t and a radius r, and a
    node is at (x, r sin t, r cos t).

    Attributes:
        axes: along, across or around, through the thickness.
        bent: whether the second axis is an angle [rad] and the third one a radius.
        hollow: what a notch leaves out; its nodes are there, without mass, and no point sees them.
    """

    axes: tuple[Axis, Axis, Axis]
    bent: bool
    hollow: Hollow | None = None

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
        return self.place(along.ravel(), across.ravel(), through.ravel())

    @cached_property
    def volumes(self) -> FloatArray:
        """Volume that belongs to each node, shape (n,) [m^3]."""
        along, across, _ = (axis.widths for axis in self.axes)
        through = self._thickness_parts(self.axes[2].bounds)
        volumes = along[:, None, None] * across[:, None] * through
        if self.hollow is not None:
            bottom = self.axes[2].positions[self.hollow.bottom]
            left = self._thickness_parts(np.minimum(self.axes[2].bounds, bottom))
            volumes = np.where(self.hollow.columns[..., None], along[:, None, None] * across[:, None] * left, volumes)
        return volumes.ravel()

    def _thickness_parts(self, bounds: FloatArray) -> FloatArray:
        return 0.5 * np.diff(bounds * bounds) if self.bent else np.diff(bounds)

    @cached_property
    def present(self) -> npt.NDArray[np.bool_]:
        """The nodes that no notch leaves out, as marks of shape (n,)."""
        there = np.ones(self.shape, dtype=bool)
        if self.hollow is not None:
            there[self.hollow.columns, self.hollow.bottom + 1 :] = False
        return there.ravel()

    @cached_property
    def reading_places(self) -> FloatArray:
        """Fractional indices of the axes at which the fields of the nodes are read, shape (n, 3).

        A node is read where it is; one that a notch leaves out, whose neighbours may all lie in one plane, at the bottom of the
        notch below it.
        """
        places = np.stack(np.unravel_index(np.arange(self.node_count), self.shape), axis=-1).astype(np.float64)
        if self.hollow is not None:
            places[~self.present, 2] = self.hollow.bottom
        return places

    @property
    def top_nodes(self) -> IntArray:
        """The outermost node of each column, shape (columns,)."""
        layers = self.shape[2]
        last = self.present.reshape(-1, layers).sum(axis=1) - 1
        return np.arange(len(last)) * layers + last

    def place(self, along: FloatArray, across: FloatArray, through: FloatArray) -> FloatArray:
        """Return the points at coordinates of the axes, shape (m, 3) [m]."""
        if not self.bent:
            return np.stack([along, across, through], axis=-1)
        sine, cosine = self.turn(across)
        return np.stack([along, through * sine, through * cosine], axis=-1)

    def turn(self, across: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return sine and cosine of the angle by which the frame of a point is turned about -x; 0 and 1 of a straight body."""
        if not self.bent:
            return np.zeros_like(across), np.ones_like(across)
        return sine_of_pi(across / np.pi), sine_of_pi(0.5 - across / np.pi)

    def number(self, along: IntArray, across: IntArray, through: IntArray) -> IntArray:
        """Return the numbers of nodes by their indices; those of a closed axis count on beyond its seam."""
        _, m, k = self.shape
        return (along * m + across % m) * k + through

    def columns(self) -> IntArray:
        """Return the nodes of each column through the thickness, shape (columns, layers)."""
        return np.arange(self.node_count).reshape(-1, self.shape[2])
