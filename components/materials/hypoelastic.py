"""Hypoelasticity with the Jaumann rate: Ds/Dt = 2 mu dev(D) + W s - s W, dp/dt = -K tr(D), in plane strain.

sigma' = lambda tr(D) I + 2 mu D, rotated with the material. The rotation over a step is the exact one of Hughes and Winget
(Int. J. Numer. Methods Eng. 15 (1980) 1862), whose limit is Wilkins' first-order formula: a rigid motion keeps the invariants
of the stress for any step. The mid-step increment C : D is rotated by the second half of the rotation, which makes the update
second order. Valid for small elastic strains; rotations and plastic strains may be large.
Source: M. L. Wilkins, Methods in Computational Physics 3 (1964) 211; S. G. Psakhie et al., Physical Mesomechanics 6 (2003),
equations (6) to (9).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.elementary_functions import logarithm
from ..support.float_arrays import FloatArray
from ..support.jit import internal_inlined


class PlaneTensor(NamedTuple):
    """A symmetric tensor in plane strain: its in-plane entries, and zz."""

    xx: float
    yy: float
    zz: float
    xy: float


@internal_inlined
def spin_rotation(spin):
    """Return cos and sin of the angle whose half has the tangent spin / 2.

    Args:
        spin: (dv_y/dx - dv_x/dy) / 2 times the step, at mid-step [rad].
    """
    half = 0.5 * spin
    square = half * half
    scale = 1.0 / (1.0 + square)
    return (1.0 - square) * scale, 2.0 * half * scale


@internal_inlined
def rotate_stress(xx, yy, xy, cosine, sine):
    """Return the in-plane stresses [Pa] rotated by an angle; zz does not change."""
    return rotate_by_half_angle(xx, yy, xy, cosine * cosine - sine * sine, 2.0 * sine * cosine)


@internal_inlined
def rotate_by_half_angle(xx, yy, xy, cosine, sine):
    """Return the in-plane entries of a symmetric tensor, rotated by half of an angle."""
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    turned = half * cosine - xy * sine
    return mean + turned, mean - turned, half * sine + xy * cosine


@internal_inlined
def elastic_increment(exx, eyy, exy, first_lame, shear):
    """Return the increments of the stresses xx, yy, zz, xy [Pa] for a strain; exy is half the engineering shear strain."""
    volume = first_lame * (exx + eyy)
    double = 2.0 * shear
    return volume + double * exx, volume + double * eyy, volume, double * exy


@internal_inlined
def energy_density(xx, yy, zz, xy, first_lame, shear):
    """Return the elastic energy per volume of a stress: p^2 / 2K + s:s / 4 mu [J/m^3]."""
    pressure = -(xx + yy + zz) / 3.0
    bulk = first_lame + 2.0 * shear / 3.0
    sxx, syy, szz = xx + pressure, yy + pressure, zz + pressure
    deviator = sxx * sxx + syy * syy + szz * szz + 2.0 * (xy * xy)
    return pressure * pressure / (2.0 * bulk) + deviator / (4.0 * shear)


def logarithmic_strain(
    xx: FloatArray, xy: FloatArray, yx: FloatArray, yy: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the entries xx, yy, xy of ln V, V^2 = F F^T, for the displacement gradients H = F - 1, each of shape (m,).

    With F = V R = R U, C : ln V is the stress C : ln U of the unrotated body, rotated by R. It is the limit of the rate above
    if the axes of stretch rotate with the body. det F must be positive; rotations may have any angle.
    """
    # B = F F^T: mean and deviator of B - 1; its eigenvalues are 1 + mean +- radius.
    first, second = 2.0 * xx + xx * xx + xy * xy, 2.0 * yy + yx * yx + yy * yy
    half, off = 0.5 * (first - second), xy + yx + xx * yx + xy * yy
    mean, radius = 0.5 * (first + second), np.sqrt(half * half + off * off)
    volume = 0.5 * _logarithm_1p(xx + yy + (xx * yy - xy * yx))
    some = np.where(radius > 0.0, radius, 1.0)
    per_deviator = np.where(radius > 0.0, 0.25 * _logarithm_1p(2.0 * radius / (1.0 + mean - radius)) / some, 0.0)
    return volume + per_deviator * half, volume - per_deviator * half, per_deviator * off


def _logarithm_1p(x: FloatArray) -> FloatArray:
    """Return ln(1 + x), to rounding also for small x (W. Kahan)."""
    above = 1.0 + x
    return np.where(above == 1.0, x, logarithm(above) * x / np.where(above == 1.0, 1.0, above - 1.0))
