"""The judgement of points: the decisive value for parting, and the plane of the crack."""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...materials.tensors import determinant, largest_principal, load_deformation_gradient, load_symmetric_tensor
from ...support.float_arrays import FloatArray
from ...support.jit import internal, internal_inlined, jit
from ..geometry.bodies import EDGES
from ..kernel_setup import Assembly
from ..parameters import ShellParameters
from .law import Point, decisive_value, may_exceed
from .pieces import Marks

# A point parts a second time if the cosine between the two crack normals is smaller than this.
_ANOTHER_DIRECTION = 0.7
# A crack plane is parallel to the wall if its normal has at least this component along the thickness, else normal to it.
_PARALLEL = 0.9
# Smaller ratios to the limit are not recorded.
_NOTED = 0.5
# The limit of unbreakable points: above any stress and strain, with a finite square.
UNBREAKABLE = 1e100
_GRIPPED = ("clamped", "moved")


class Judgement(NamedTuple):
    """The tables for the judgement of points.

    Attributes:
        law: constants of the fracture law.
        limit: of each point, shape (m,).
        along, across, through: distances of planes at the points along each axis, or angles [m].
        radius: at the points through the thickness, 1 for a straight body, shape (points through,).
        sine, cosine: of the rotation angle of the frame of each point, shape (m,).
        normal: of the first crack of each point, in index space, shape (m, 3).
        cracks: number of cracks of each point, shape (m,).
        since: tick of the last crack, shape (m,).
        wait: number of ticks for a parted point to unload.
    """

    law: Any
    limit: FloatArray
    along: FloatArray
    across: FloatArray
    through: FloatArray
    radius: FloatArray
    sine: FloatArray
    cosine: FloatArray
    normal: FloatArray
    cracks: npt.NDArray[np.int64]
    since: npt.NDArray[np.int64]
    wait: int


@jit
def find_parting(judged, stress, gradient, plastic_strain, found, nearest, tick):
    """Write the points that pass their limit, ascending, and return their number.

    A parted point passes its limit if its stress has another direction, or after the time for unloading.

    Args:
        judged: `Judgement`.
        stress: mean stress over columns, shape (m, 6) [Pa].
        gradient: of the displacement, shape (m, 9).
        plastic_strain: shape (m,); (0,) for an elastic body.
        found: written, shape (m,).
        nearest: largest ratio to the limit so far of intact points, from one half on, with its point and its tick; updated,
            shape (3,).
        tick: number of the tick.
    """
    count = 0
    for p in range(judged.limit.size):
        largest = min(max(nearest[0], _NOTED), 1.0)
        if not may_exceed(judged.law, largest * judged.limit[p], load_symmetric_tensor(stress, p), flown(plastic_strain, p)):
            continue
        value, nx, ny, nz = judge(judged.law, stress, gradient, plastic_strain, p)
        if judged.cracks[p] == 0 and value > nearest[0] * judged.limit[p] and value > _NOTED * judged.limit[p]:
            nearest[0], nearest[1], nearest[2] = value / judged.limit[p], p, tick
        if value > judged.limit[p]:
            if judged.cracks[p] > 0 and tick < judged.since[p] + judged.wait:
                if judged.cracks[p] > 1:
                    continue
                a, b, c = index_normal(judged, gradient, p, nx, ny, nz)
                if abs(a * judged.normal[p, 0] + b * judged.normal[p, 1] + c * judged.normal[p, 2]) >= _ANOTHER_DIRECTION:
                    continue
            found[count] = p
            count += 1
    return count


@jit
def write_judgements(judged, stress, gradient, plastic_strain, points, out):
    """Write for some points the decisive value, and the crack normal in index space, shape (k, 4); like `find_parting`."""
    for number in range(points.size):
        p = points[number]
        value, nx, ny, nz = judge(judged.law, stress, gradient, plastic_strain, p)
        out[number, 0] = value
        out[number, 1], out[number, 2], out[number, 3] = index_normal(judged, gradient, p, nx, ny, nz)


@internal_inlined
def flown(plastic_strain, p):
    """Return the plastic strain of a point, 0 for an elastic body."""
    return plastic_strain[p] if plastic_strain.size > 0 else 0.0


@internal
def judge(law, stress, gradient, plastic_strain, p):
    """Return the decisive value of a point and the direction of its largest principal stress."""
    volume = determinant(load_deformation_gradient(gradient, p))
    largest, nx, ny, nz = largest_principal(load_symmetric_tensor(stress, p))
    return decisive_value(law, Point(largest, volume, flown(plastic_strain, p))), nx, ny, nz


@internal
def index_normal(judged, h, p, nx, ny, nz):
    """Return the unit normal, in index space, of the reference plane whose present normal is (nx, ny, nz).

    The normal lies in the surface of the body or along the thickness, and points towards increasing indices.
    """
    x = nx * (1.0 + h[p, 0]) + ny * h[p, 3] + nz * h[p, 6]
    y = nx * h[p, 1] + ny * (1.0 + h[p, 4]) + nz * h[p, 7]
    z = nx * h[p, 2] + ny * h[p, 5] + nz * (1.0 + h[p, 8])
    c, s = judged.cosine[p], judged.sine[p]
    around, out = c * y - s * z, s * y + c * z
    size = sqrt(x * x + around * around + out * out)
    if abs(out) > _PARALLEL * size:
        return 0.0, 0.0, 1.0
    through = judged.through.size
    column, layer = p // through, p % through
    a = x * judged.along[column // judged.across.size]
    b = around * judged.across[column % judged.across.size] * judged.radius[layer]
    size = sqrt(a * a + b * b)
    if a < 0.0 and -a >= abs(b) or b < 0.0 and -b > abs(a):
        size = -size
    return a / size, b / size, 0.0


def points_in_grips(p: ShellParameters, assembly: Assembly, length: float) -> Marks:
    """Return which points lie within a length of a clamped or moved edge, shape (m,).

    Raises:
        ParameterError: there is no such edge, or all points lie within the length.
    """
    places: FloatArray = assembly.points.all_places()
    found: Marks = places[:, 0] < -1.0
    for edge, kind in p.boundaries.items():
        if kind in _GRIPPED and length > 0.0:
            number, end = EDGES[edge]
            axis = assembly.lattice.axes[number]
            found |= abs(axis.at(places[:, number]) - axis.positions[end]) < length
    at = ("fracture", "grip_length")
    if length > 0.0 and not any(kind in _GRIPPED for kind in p.boundaries.values()):
        raise ParameterError(f"got {length:g} m, but no edge is {' or '.join(_GRIPPED)}", hint="leave it out", at=at)
    if found.all():
        raise ParameterError(f"got {length:g} m, so that nothing of the body could part", hint="give a smaller one", at=at)
    return found
