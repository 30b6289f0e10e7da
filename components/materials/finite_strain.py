"""Strain and rotation of a tick in three dimensions, and the stress that turns with the material.

With F before and G after a tick, the velocity gradient of its middle is L dt = 2 (G - F) (G + F)^-1; D dt is its symmetric
part, W dt the other one. The stress turns by Q = (I - W dt / 2)^-1 (I + W dt / 2), so that a rigid rotation strains nothing and
leaves the invariants of the stress alone to rounding, whatever the step; tau + dt (W tau - tau W) is its limit. The strain of
the middle is turned by half of the spin, to where the stress is by then: else strain and rotation together would leave an error
of first order in the step, 8e-4 where 1,000 ticks turn by 90 degrees; so it is of second order, 6e-7.
Source: T. J. R. Hughes, J. Winget, Int. J. Numer. Methods Eng. 15 (1980) 1862; in the plane: `hypoelastic`.

A tensor is nine numbers in the order xx, xy, xz, yx, yy, yz, zx, zy, zz, a symmetric one six: xx, yy, zz, xy, yz, zx. Shear
strains are those of the tensor, half the engineering ones.
"""

from __future__ import annotations

from ..support.jit import inlined, internal_inlined


@internal_inlined
def inverse(xx, xy, xz, yx, yy, yz, zx, zy, zz):
    """Return the nine entries of the inverse of a tensor; infinite where it has none."""
    cofactor_x, cofactor_y, cofactor_z = yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx
    scale = 1.0 / (xx * cofactor_x + xy * cofactor_y + xz * cofactor_z)
    return (
        scale * cofactor_x, scale * (xz * zy - xy * zz), scale * (xy * yz - xz * yy),
        scale * cofactor_y, scale * (xx * zz - xz * zx), scale * (xz * yx - xx * yz),
        scale * cofactor_z, scale * (xy * zx - xx * zy), scale * (xx * yy - xy * yx),
    )  # fmt: skip


@inlined
def strain_and_spin(fxx, fxy, fxz, fyx, fyy, fyz, fzx, fzy, fzz, gxx, gxy, gxz, gyx, gyy, gyz, gzx, gzy, gzz):
    """Return D dt of a tick as xx, yy, zz, xy, yz, zx, as the end of the tick sees it, and W dt as xy, yz, zx.

    fxx to fzz is the deformation gradient dx_i/dX_j before the tick, gxx to gzz that after it.
    """
    ixx, ixy, ixz, iyx, iyy, iyz, izx, izy, izz = inverse(
        fxx + gxx, fxy + gxy, fxz + gxz, fyx + gyx, fyy + gyy, fyz + gyz, fzx + gzx, fzy + gzy, fzz + gzz
    )
    axx, axy, axz = gxx - fxx, gxy - fxy, gxz - fxz
    ayx, ayy, ayz = gyx - fyx, gyy - fyy, gyz - fyz
    azx, azy, azz = gzx - fzx, gzy - fzy, gzz - fzz
    # Half of L dt off the diagonal: sums and differences make D dt and W dt.
    lxy, lyx = axx * ixy + axy * iyy + axz * izy, ayx * ixx + ayy * iyx + ayz * izx
    lyz, lzy = ayx * ixz + ayy * iyz + ayz * izz, azx * ixy + azy * iyy + azz * izy
    lzx, lxz = azx * ixx + azy * iyx + azz * izx, axx * ixz + axy * iyz + axz * izz
    spin_xy, spin_yz, spin_zx = lxy - lyx, lyz - lzy, lzx - lxz
    xx, yy, zz, xy, yz, zx = turn_stress(
        2.0 * (axx * ixx + axy * iyx + axz * izx),
        2.0 * (ayx * ixy + ayy * iyy + ayz * izy),
        2.0 * (azx * ixz + azy * iyz + azz * izz),
        lxy + lyx, lyz + lzy, lzx + lxz, 0.5 * spin_xy, 0.5 * spin_yz, 0.5 * spin_zx,
    )  # fmt: skip
    return xx, yy, zz, xy, yz, zx, spin_xy, spin_yz, spin_zx


@inlined
def turn_stress(xx, yy, zz, xy, yz, zx, spin_xy, spin_yz, spin_zx):
    """Return a stress, or another symmetric tensor, turned by the spin W dt of a tick."""
    x, y, z = -0.5 * spin_yz, -0.5 * spin_zx, -0.5 * spin_xy
    scale = 2.0 / (1.0 + (x * x + y * y + z * z))
    qxx, qxy, qxz = 1.0 - scale * (y * y + z * z), scale * (x * y - z), scale * (z * x + y)
    qyx, qyy, qyz = scale * (x * y + z), 1.0 - scale * (z * z + x * x), scale * (y * z - x)
    qzx, qzy, qzz = scale * (z * x - y), scale * (y * z + x), 1.0 - scale * (x * x + y * y)
    # Q tau, row by row, and that times Q^T.
    axx, axy, axz = qxx * xx + qxy * xy + qxz * zx, qxx * xy + qxy * yy + qxz * yz, qxx * zx + qxy * yz + qxz * zz
    ayx, ayy, ayz = qyx * xx + qyy * xy + qyz * zx, qyx * xy + qyy * yy + qyz * yz, qyx * zx + qyy * yz + qyz * zz
    azx, azy, azz = qzx * xx + qzy * xy + qzz * zx, qzx * xy + qzy * yy + qzz * yz, qzx * zx + qzy * yz + qzz * zz
    return (
        axx * qxx + axy * qxy + axz * qxz,
        ayx * qyx + ayy * qyy + ayz * qyz,
        azx * qzx + azy * qzy + azz * qzz,
        axx * qyx + axy * qyy + axz * qyz,
        ayx * qzx + ayy * qzy + ayz * qzz,
        azx * qxx + azy * qxy + azz * qxz,
    )  # fmt: skip


@inlined
def nominal_stress(fxx, fxy, fxz, fyx, fyy, fyz, fzx, fzy, fzz, xx, yy, zz, xy, yz, zx):
    """Return the nominal stress P = F^-1 tau [Pa], nine numbers: P_ji works on dN/dX_j and gives the force along i.

    fxx to fzz is the deformation gradient dx_i/dX_j, xx to zx the Kirchhoff stress [Pa].
    """
    ixx, ixy, ixz, iyx, iyy, iyz, izx, izy, izz = inverse(fxx, fxy, fxz, fyx, fyy, fyz, fzx, fzy, fzz)
    return (
        ixx * xx + ixy * xy + ixz * zx, ixx * xy + ixy * yy + ixz * yz, ixx * zx + ixy * yz + ixz * zz,
        iyx * xx + iyy * xy + iyz * zx, iyx * xy + iyy * yy + iyz * yz, iyx * zx + iyy * yz + iyz * zz,
        izx * xx + izy * xy + izz * zx, izx * xy + izy * yy + izz * yz, izx * zx + izy * yz + izz * zz,
    )  # fmt: skip
