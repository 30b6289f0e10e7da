"""Tensors in three dimensions as named tuples, and their invariants from + x / and sqrt alone: bitwise the same everywhere.

Tension is positive. Shear strains are tensor components, half the engineering ones.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from ..support.jit import internal_inlined

# Jacobi's rotations stop when the squared off-diagonal entries are smaller than this, relative to the squared tensor. They
# converge quadratically, so that the limit on their number is never reached.
_SMALL, _ROUNDS = 1e-30, 12


class Tensor(NamedTuple):
    """A tensor, for example the deformation gradient dx_i/dX_j."""

    xx: float
    xy: float
    xz: float
    yx: float
    yy: float
    yz: float
    zx: float
    zy: float
    zz: float


class SymmetricTensor(NamedTuple):
    """A symmetric tensor: a stress [Pa] or a strain."""

    xx: float
    yy: float
    zz: float
    xy: float
    yz: float
    zx: float


class Principal(NamedTuple):
    """A principal value of a symmetric tensor, and the unit vector along its axis."""

    value: float
    x: float
    y: float
    z: float


class Moduli(NamedTuple):
    """Lame's constants [Pa]: lambda, and the shear modulus mu."""

    first_lame: float
    shear: float


@internal_inlined
def load_deformation_gradient(gradient, p):
    """Return the deformation gradient 1 + H of row p of displacement gradients H, shape (m, 9)."""
    h = gradient
    return Tensor(
        1.0 + h[p, 0], h[p, 1], h[p, 2], h[p, 3], 1.0 + h[p, 4], h[p, 5], h[p, 6], h[p, 7], 1.0 + h[p, 8]
    )  # fmt: skip


@internal_inlined
def load_symmetric_tensor(rows, p):
    """Return row p of symmetric tensors, shape (m, 6)."""
    return SymmetricTensor(rows[p, 0], rows[p, 1], rows[p, 2], rows[p, 3], rows[p, 4], rows[p, 5])


@internal_inlined
def store_symmetric_tensor(rows, p, tensor):
    """Write row p of symmetric tensors, shape (m, 6)."""
    rows[p, 0], rows[p, 1], rows[p, 2] = tensor.xx, tensor.yy, tensor.zz
    rows[p, 3], rows[p, 4], rows[p, 5] = tensor.xy, tensor.yz, tensor.zx


@internal_inlined
def determinant(f):
    """Return the determinant of a tensor."""
    return f.xx * (f.yy * f.zz - f.yz * f.zy) + f.xy * (f.yz * f.zx - f.yx * f.zz) + f.xz * (f.yx * f.zy - f.yy * f.zx)


@internal_inlined
def inverse(f):
    """Return the inverse of a tensor; infinite for a singular one."""
    x, y, z = f.yy * f.zz - f.yz * f.zy, f.yz * f.zx - f.yx * f.zz, f.yx * f.zy - f.yy * f.zx
    scale = 1.0 / (f.xx * x + f.xy * y + f.xz * z)
    return Tensor(
        scale * x, scale * (f.xz * f.zy - f.xy * f.zz), scale * (f.xy * f.yz - f.xz * f.yy),
        scale * y, scale * (f.xx * f.zz - f.xz * f.zx), scale * (f.xz * f.yx - f.xx * f.yz),
        scale * z, scale * (f.xy * f.zx - f.xx * f.zy), scale * (f.xx * f.yy - f.xy * f.yx),
    )  # fmt: skip


@internal_inlined
def add(a, b):
    """Return the sum of two symmetric tensors."""
    return SymmetricTensor(a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.yz + b.yz, a.zx + b.zx)


@internal_inlined
def subtract(a, b):
    """Return the difference of two symmetric tensors."""
    return SymmetricTensor(a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.yz - b.yz, a.zx - b.zx)


@internal_inlined
def contract(a, b):
    """Return the double contraction a:b of two symmetric tensors."""
    return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2.0 * (a.xy * b.xy + a.yz * b.yz + a.zx * b.zx)


@internal_inlined
def trace(a):
    """Return the trace of a symmetric tensor."""
    return a.xx + a.yy + a.zz


@internal_inlined
def equivalent_stress(stress):
    """Return von Mises' equivalent stress sqrt(3/2 s:s) [Pa], s the deviator."""
    return sqrt(equivalent_square(stress))


@internal_inlined
def equivalent_square(stress):
    """Return the square of von Mises' equivalent stress [Pa^2]."""
    a, b, c = stress.xx - stress.yy, stress.yy - stress.zz, stress.zz - stress.xx
    shears = stress.xy * stress.xy + stress.yz * stress.yz + stress.zx * stress.zx
    return 0.5 * (a * a + b * b + c * c) + 3.0 * shears


@internal_inlined
def elastic_energy_density(stress, moduli):
    """Return the elastic energy per volume of a stress: p^2 / 2K + s:s / 4 mu [J/m^3]."""
    mean, equivalent = trace(stress) / 3.0, equivalent_stress(stress)
    bulk = moduli.first_lame + 2.0 * moduli.shear / 3.0
    return mean * mean / (2.0 * bulk) + equivalent * equivalent / (6.0 * moduli.shear)


@internal_inlined
def trial_stress(stress, strain, moduli):
    """Return a stress after an elastic increment of strain: tau + lambda tr(d) 1 + 2 mu d [Pa]."""
    volume, double = moduli.first_lame * trace(strain), 2.0 * moduli.shear
    return SymmetricTensor(
        stress.xx + volume + double * strain.xx, stress.yy + volume + double * strain.yy,
        stress.zz + volume + double * strain.zz, stress.xy + double * strain.xy, stress.yz + double * strain.yz,
        stress.zx + double * strain.zx,
    )  # fmt: skip


@internal_inlined
def largest_principal(stress):
    """Return the largest principal value of a symmetric tensor and its axis, a `Principal`.

    For a double principal value it is one of the corresponding axes.
    Source: Jacobi's rotations, as in G. H. Golub, C. F. Van Loan, Matrix Computations (2013), section 8.5.
    """
    xx, yy, zz, xy, yz, zx = stress.xx, stress.yy, stress.zz, stress.xy, stress.yz, stress.zx
    ax, ay, az = 1.0, 0.0, 0.0
    bx, by, bz = 0.0, 1.0, 0.0
    cx, cy, cz = 0.0, 0.0, 1.0
    limit = _SMALL * contract(stress, stress)
    for _ in range(_ROUNDS):
        if not xy * xy + yz * yz + zx * zx > limit:
            break
        cosine, sine, tangent = _jacobi_rotation(xx, yy, xy)
        xx, yy, xy = xx - tangent * xy, yy + tangent * xy, 0.0
        zx, yz = cosine * zx - sine * yz, sine * zx + cosine * yz
        ax, bx = cosine * ax - sine * bx, sine * ax + cosine * bx
        ay, by = cosine * ay - sine * by, sine * ay + cosine * by
        az, bz = cosine * az - sine * bz, sine * az + cosine * bz
        cosine, sine, tangent = _jacobi_rotation(yy, zz, yz)
        yy, zz, yz = yy - tangent * yz, zz + tangent * yz, 0.0
        xy, zx = cosine * xy - sine * zx, sine * xy + cosine * zx
        bx, cx = cosine * bx - sine * cx, sine * bx + cosine * cx
        by, cy = cosine * by - sine * cy, sine * by + cosine * cy
        bz, cz = cosine * bz - sine * cz, sine * bz + cosine * cz
        cosine, sine, tangent = _jacobi_rotation(zz, xx, zx)
        zz, xx, zx = zz - tangent * zx, xx + tangent * zx, 0.0
        yz, xy = cosine * yz - sine * xy, sine * yz + cosine * xy
        cx, ax = cosine * cx - sine * ax, sine * cx + cosine * ax
        cy, ay = cosine * cy - sine * ay, sine * cy + cosine * ay
        cz, az = cosine * cz - sine * az, sine * cz + cosine * az
    if xx >= yy and xx >= zz:
        return Principal(xx, ax, ay, az)
    if yy >= zz:
        return Principal(yy, bx, by, bz)
    return Principal(zz, cx, cy, cz)


@internal_inlined
def _jacobi_rotation(first, second, off_diagonal):
    """Return cosine, sine and tangent of the rotation that makes the entry between two axes vanish."""
    if off_diagonal == 0.0:
        return 1.0, 0.0, 0.0
    half = 0.5 * (second - first) / off_diagonal
    root = sqrt(half * half + 1.0)
    tangent = 1.0 / (half + root) if half >= 0.0 else 1.0 / (half - root)
    cosine = 1.0 / sqrt(tangent * tangent + 1.0)
    return cosine, tangent * cosine, tangent
