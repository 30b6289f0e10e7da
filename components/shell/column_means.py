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

from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .geometry.lattice import Lattice
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
    columns = np.arange(along * across).reshape(along, across)
    rows = np.arange(along)[:, None]
    sides = [columns[np.maximum(rows - 1, 0)[:, 0]], columns[np.minimum(rows + 1, along - 1)[:, 0]]]
    sides += [np.roll(columns, 1, axis=1), np.roll(columns, -1, axis=1)]
    if not lattice.axes[1].closed:
        sides[2][:, 0], sides[3][:, -1] = columns[:, 0], columns[:, -1]
    around = np.stack([side.ravel() for side in sides], axis=1)
    # Below a notch points lie at other heights.
    lowest = points.heights.reshape(-1, through)[:, 0]
    alike = np.where(lowest[around] == lowest[:, None], around, columns.reshape(-1, 1)).astype(np.int32)
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
        xx, yy, zz = mean(stress, p, q, r, 0), mean(stress, p, q, r, 1), mean(stress, p, q, r, 2)
        xy, yz, zx = mean(stress, p, q, r, 3), mean(stress, p, q, r, 4), mean(stress, p, q, r, 5)
        half[p, 0], half[p, 1], half[p, 2], half[p, 3], half[p, 4], half[p, 5] = rotate_stress(
            means.cosine[p], means.sine[p], xx, yy, zz, xy, yz, zx
        )
    for p in range(stress.shape[0]):
        q, r = neighbours(means, p, 2, through)
        xx, yy, zz = mean(half, p, q, r, 0), mean(half, p, q, r, 1), mean(half, p, q, r, 2)
        xy, yz, zx = mean(half, p, q, r, 3), mean(half, p, q, r, 4), mean(half, p, q, r, 5)
        out[p, 0], out[p, 1], out[p, 2], out[p, 3], out[p, 4], out[p, 5] = rotate_stress(
            means.cosine[p], -means.sine[p], xx, yy, zz, xy, yz, zx
        )


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
def mean(values, p, q, r, entry):
    """Return the mean of an entry at three points, the first with twice the weight."""
    return 0.5 * values[p, entry] + 0.25 * (values[q, entry] + values[r, entry])


@internal
def rotate_stress(c, s, xx, yy, zz, xy, yz, zx):
    """Return a stress in a frame that is rotated about x."""
    return (
        xx, c * c * yy - 2.0 * c * s * yz + s * s * zz, s * s * yy + 2.0 * c * s * yz + c * c * zz, c * xy - s * zx,
        c * s * (yy - zz) + (c * c - s * s) * yz, s * xy + c * zx,
    )  # fmt: skip
