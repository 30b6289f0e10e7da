"""The fracture check of points: the value that the law compares with its limit, and the plane of the crack."""

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
from .laws.fracture_law import Point, decisive_value, may_exceed
from .pieces import Marks

# A point may crack a second time if the cosine between both crack normals is smaller than this.
_ANOTHER_DIRECTION = 0.7
# A crack plane is parallel to the wall if its normal has at least this component along the thickness; else it is normal to it.
_PARALLEL = 0.9
# Smaller fracture ratios are not recorded as the largest one.
_NOTED = 0.5
# Limit of points that cannot break: above any stress and strain, with a square that does not overflow.
UNBREAKABLE = 1e100
_GRIPPED = ("clamped", "moved")


class FractureCheck(NamedTuple):
    """The tables for the fracture check of points.

    Attributes:
        law: constants of the fracture law.
        limit: limit of each point for the value that the law tests, shape (m,).
        along, across, through: distance of planes of nodes at the points along each axis [m, or rad around a tube].
        radius: radius of the points through the thickness, 1 for a straight body, shape (points through,).
        sine, cosine: of the rotation angle of the frame of each point, shape (m,).
        normal: normal of the first crack of each point, in index space, shape (m, 3).
        cracks: number of cracks of each point, shape (m,).
        since: tick of the last crack, shape (m,).
        wait: number of ticks in which a cracked point unloads.
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
def find_cracking_points(check, stress, gradient, plastic_strain, points_out, largest_ratio, tick):
    """Write the points whose fracture value exceeds their limit, ascending, and return their number.

    A cracked point counts if its stress has another direction than at its crack, or after the time for unloading.

    Args:
        check: `FractureCheck`.
        stress: mean stress over columns, shape (m, 6) [Pa].
        gradient: displacement gradient, shape (m, 9).
        plastic_strain: shape (m,); (0,) for an elastic body.
        points_out: written, shape (m,).
        largest_ratio: largest ratio to the limit so far of intact points, from one half on, with its point and its tick;
            updated, shape (3,).
        tick: number of the tick.
    """
    count = 0
    for p in range(check.limit.size):
        largest = min(max(largest_ratio[0], _NOTED), 1.0)
        if not may_exceed(
            check.law, largest * check.limit[p], load_symmetric_tensor(stress, p), point_plastic_strain(plastic_strain, p)
        ):
            continue
        value, nx, ny, nz = fracture_value(check.law, stress, gradient, plastic_strain, p)
        if check.cracks[p] == 0 and value > largest_ratio[0] * check.limit[p] and value > _NOTED * check.limit[p]:
            largest_ratio[0], largest_ratio[1], largest_ratio[2] = value / check.limit[p], p, tick
        if value > check.limit[p]:
            if check.cracks[p] > 0 and tick < check.since[p] + check.wait:
                if check.cracks[p] > 1:
                    continue
                a, b, c = index_normal(check, gradient, p, nx, ny, nz)
                if abs(a * check.normal[p, 0] + b * check.normal[p, 1] + c * check.normal[p, 2]) >= _ANOTHER_DIRECTION:
                    continue
            points_out[count] = p
            count += 1
    return count


@jit
def write_fracture_values(check, stress, gradient, plastic_strain, points, out):
    """Write for each of `points` the value that its law tests, and the crack normal in index space, shape (k, 4)."""
    for number in range(points.size):
        p = points[number]
        value, nx, ny, nz = fracture_value(check.law, stress, gradient, plastic_strain, p)
        out[number, 0] = value
        out[number, 1], out[number, 2], out[number, 3] = index_normal(check, gradient, p, nx, ny, nz)


@internal_inlined
def point_plastic_strain(plastic_strain, p):
    """Return the plastic strain of a point, 0 for an elastic body."""
    return plastic_strain[p] if plastic_strain.size > 0 else 0.0


@internal
def fracture_value(law, stress, gradient, plastic_strain, p):
    """Return the value of a point that the law tests, and the direction of its largest principal stress."""
    volume = determinant(load_deformation_gradient(gradient, p))
    largest, nx, ny, nz = largest_principal(load_symmetric_tensor(stress, p))
    return decisive_value(law, Point(largest, volume, point_plastic_strain(plastic_strain, p))), nx, ny, nz


@internal
def index_normal(check, h, p, nx, ny, nz):
    """Return the unit normal, in index space, of the crack plane whose normal in the present body is (nx, ny, nz).

    It lies in the surface of the body or along the thickness, and points towards increasing indices.
    """
    x = nx * (1.0 + h[p, 0]) + ny * h[p, 3] + nz * h[p, 6]
    y = nx * h[p, 1] + ny * (1.0 + h[p, 4]) + nz * h[p, 7]
    z = nx * h[p, 2] + ny * h[p, 5] + nz * (1.0 + h[p, 8])
    c, s = check.cosine[p], check.sine[p]
    around, out = c * y - s * z, s * y + c * z
    size = sqrt(x * x + around * around + out * out)
    if abs(out) > _PARALLEL * size:
        return 0.0, 0.0, 1.0
    through = check.through.size
    column, layer = p // through, p % through
    a = x * check.along[column // check.across.size]
    b = around * check.across[column % check.across.size] * check.radius[layer]
    size = sqrt(a * a + b * b)
    if a < 0.0 and -a >= abs(b) or b < 0.0 and -b > abs(a):
        size = -size
    return a / size, b / size, 0.0


def points_in_grips(p: ShellParameters, assembly: Assembly, length: float) -> Marks:
    """Return which points lie within `length` of a clamped or moved edge and must not crack, shape (m,).

    Raises:
        ParameterError: there is no such edge, or all points lie within the length.
    """
    places: FloatArray = assembly.points.all_indices()
    found: Marks = places[:, 0] < -1.0
    for edge, kind in p.boundaries.items():
        if kind in _GRIPPED and length > 0.0:
            number, end = EDGES[edge]
            axis = assembly.lattice.axes[number]
            found |= abs(axis.coordinates(places[:, number]) - axis.positions[end]) < length
    at = ("fracture", "grip_length")
    if length > 0.0 and not any(kind in _GRIPPED for kind in p.boundaries.values()):
        raise ParameterError(f"got {length:g} m, but no edge is {' or '.join(_GRIPPED)}", hint="leave it out", at=at)
    if found.all():
        raise ParameterError(f"got {length:g} m, so that no point of the body could part", hint="give a smaller length", at=at)
    return found
