"""Invariants of a stress in three dimensions, and its largest principal value: + x / and sqrt alone, the same bits everywhere.

A symmetric tensor is six numbers in the order xx, yy, zz, xy, yz, zx; tension is positive.
"""

from __future__ import annotations

from math import sqrt

from ..support.jit import inlined, internal_inlined

# The rotations of Jacobi end where what is off the diagonal is smaller than this, relative to the tensor, squared; they
# converge quadratically, so that the limit on their rounds is never met.
_SMALL, _ROUNDS = 1e-30, 12


@internal_inlined
def mean_stress(xx, yy, zz):
    """Return a third of the trace [Pa]: minus the pressure."""
    return (xx + yy + zz) / 3.0


@inlined
def equivalent_stress(xx, yy, zz, xy, yz, zx):
    """Return von Mises' equivalent stress sqrt(3/2 s:s) [Pa], s the deviator."""
    a, b, c = xx - yy, yy - zz, zz - xx
    return sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * (xy * xy + yz * yz + zx * zx))


@inlined
def elastic_energy_density(xx, yy, zz, xy, yz, zx, first_lame, shear):
    """Return the elastic energy per volume of a stress: p^2 / 2K + s:s / 4 mu [J/m^3]."""
    mean = mean_stress(xx, yy, zz)
    equivalent = equivalent_stress(xx, yy, zz, xy, yz, zx)
    bulk = first_lame + 2.0 * shear / 3.0
    return mean * mean / (2.0 * bulk) + equivalent * equivalent / (6.0 * shear)


@inlined
def largest_principal(xx, yy, zz, xy, yz, zx):
    """Return the largest principal stress [Pa], and the three components of the unit vector along it.

    Where two principal stresses are equal, the vector is one of those that belong to them.
    Source: Jacobi's rotations, as in G. H. Golub, C. F. Van Loan, Matrix Computations (2013), section 8.5.
    """
    ax, ay, az = 1.0, 0.0, 0.0
    bx, by, bz = 0.0, 1.0, 0.0
    cx, cy, cz = 0.0, 0.0, 1.0
    limit = _SMALL * (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + zx * zx))
    for _ in range(_ROUNDS):
        if not xy * xy + yz * yz + zx * zx > limit:
            break
        cosine, sine, tangent = _rotation(xx, yy, xy)
        xx, yy, xy = xx - tangent * xy, yy + tangent * xy, 0.0
        zx, yz = cosine * zx - sine * yz, sine * zx + cosine * yz
        ax, bx = cosine * ax - sine * bx, sine * ax + cosine * bx
        ay, by = cosine * ay - sine * by, sine * ay + cosine * by
        az, bz = cosine * az - sine * bz, sine * az + cosine * bz
        cosine, sine, tangent = _rotation(yy, zz, yz)
        yy, zz, yz = yy - tangent * yz, zz + tangent * yz, 0.0
        xy, zx = cosine * xy - sine * zx, sine * xy + cosine * zx
        bx, cx = cosine * bx - sine * cx, sine * bx + cosine * cx
        by, cy = cosine * by - sine * cy, sine * by + cosine * cy
        bz, cz = cosine * bz - sine * cz, sine * bz + cosine * cz
        cosine, sine, tangent = _rotation(zz, xx, zx)
        zz, xx, zx = zz - tangent * zx, xx + tangent * zx, 0.0
        yz, xy = cosine * yz - sine * xy, sine * yz + cosine * xy
        cx, ax = cosine * cx - sine * ax, sine * cx + cosine * ax
        cy, ay = cosine * cy - sine * ay, sine * cy + cosine * ay
        cz, az = cosine * cz - sine * az, sine * cz + cosine * az
    if xx >= yy and xx >= zz:
        return xx, ax, ay, az
    if yy >= zz:
        return yy, bx, by, bz
    return zz, cx, cy, cz


@internal_inlined
def _rotation(first, second, between):
    """Return cosine, sine and tangent of the rotation that makes the entry between two axes 0."""
    if between == 0.0:
        return 1.0, 0.0, 0.0
    half = 0.5 * (second - first) / between
    root = sqrt(half * half + 1.0)
    tangent = 1.0 / (half + root) if half >= 0.0 else 1.0 / (half - root)
    cosine = 1.0 / sqrt(tangent * tangent + 1.0)
    return cosine, tangent * cosine, tangent
