"""The stress that is judged, reported and drawn: its mean over neighbouring columns of points, with the weights 1, 2, 1.

Points at columns differentiate centrally, so that the forces that hold a column in balance come from the stresses of the two
next to it: those of even and of odd columns are balanced apart, and alternate where a step of the wall loads both differently.
The mean, along the body and then across it, has none of what alternates and all of what is linear. Only columns of the same
section are averaged; at the end of such a row the two outermost columns share theirs. A point next to one that a crack has
parted keeps its own stress in that direction: a mean would hide what drives the crack on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..materials.tensors import SymmetricTensor, store_symmetric
from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .geometry.lattice import Lattice, column_neighbours
from .kernel_arrays import ColumnArray
from .quadrature import IntegrationPoints


class ColumnMeans(NamedTuple):
    """The tables of the means, of m points in c columns, and the means.

    Attributes:
        alike: columns before and after each one along and across, itself where there is none of its section, shape (c, 4).
        sound: whether no crack has parted a point, shape (m,).
        sine, cosine: of the angle by which the frame of each point is turned, shape (m,).
        halfway: means along the body alone, in the frames of the points, shape (m, 6) [Pa].
        stress: the means, as stresses are kept, shape (m, 6) [Pa].
    """

    alike: ColumnArray
    sound: npt.NDArray[np.bool_]
    sine: FloatArray
    cosine: FloatArray
    halfway: FloatArray
    stress: FloatArray


def make_column_means(lattice: Lattice, points: IntegrationPoints) -> ColumnMeans:
    """Return the tables of a body without cracks."""
    along, across, through = (len(line.at) for line in points.lines)
    around, own = column_neighbours(along, across, lattice.axes[1].closed), np.arange(along * across)[:, None]
    # Below a notch points lie at other heights.
    lowest = points.heights.reshape(-1, through)[:, 0]
    alike = np.where(lowest[around] == lowest[:, None], around, own).astype(np.int32)
    count = len(points.volume)
    return ColumnMeans(
        alike, np.ones(count, dtype=bool), points.sine, points.cosine, np.zeros((count, 6)), np.zeros((count, 6))
    )  # fmt: skip


@jit
def write_column_means(stress, means):
    """Write the means of a stress, shape (m, 6)."""
    half, out, through = means.halfway, means.stress, stress.shape[0] // means.alike.shape[0]
    for p in range(stress.shape[0]):
        q, r = neighbours(means, p, 0, through)
        store_symmetric(half, p, rotate_about_x(means.cosine[p], means.sine[p], mean_of_three(stress, p, q, r)))
    for p in range(stress.shape[0]):
        q, r = neighbours(means, p, 2, through)
        store_symmetric(out, p, rotate_about_x(means.cosine[p], -means.sine[p], mean_of_three(half, p, q, r)))


@internal
def neighbours(means, p, side, through):
    """Return the points before and after a point: one of them twice at an end, the point itself next to a crack."""
    column, layer = p // through, p % through
    q, r = means.alike[column, side] * through + layer, means.alike[column, side + 1] * through + layer
    if not (means.sound[p] and means.sound[q] and means.sound[r]):
        return p, p
    if r == p:
        r = q
    if q == p:
        q = r
    return q, r


@internal
def mean_of_three(stress, p, q, r):
    """Return the mean of the stresses of three points, the first with twice the weight."""
    s = stress
    return SymmetricTensor(
        0.5 * s[p, 0] + 0.25 * (s[q, 0] + s[r, 0]), 0.5 * s[p, 1] + 0.25 * (s[q, 1] + s[r, 1]),
        0.5 * s[p, 2] + 0.25 * (s[q, 2] + s[r, 2]), 0.5 * s[p, 3] + 0.25 * (s[q, 3] + s[r, 3]),
        0.5 * s[p, 4] + 0.25 * (s[q, 4] + s[r, 4]), 0.5 * s[p, 5] + 0.25 * (s[q, 5] + s[r, 5]),
    )  # fmt: skip


@internal
def rotate_about_x(c, s, t):
    """Return a symmetric tensor in a frame that is rotated about x."""
    return SymmetricTensor(
        t.xx, c * c * t.yy - 2.0 * c * s * t.yz + s * s * t.zz, s * s * t.yy + 2.0 * c * s * t.yz + c * c * t.zz,
        c * t.xy - s * t.zx, c * s * (t.yy - t.zz) + (c * c - s * s) * t.yz, s * t.xy + c * t.zx,
    )  # fmt: skip
