"""Pairs of linked automata: strains that are invariant under rigid motions, and the forces conjugate to them.

The vector d from centre to centre is expressed in axes rotated by phi, the mean of both rotations. With N the initial direction
to the neighbour and T the same rotated by 90 degrees, the strains are

    eps = d . N(phi) / r - 1,        gamma = d . T(phi) / r,

which for small motions are du.n/r and du.t/r - (w_i + w_j)/2, as in Psakhie et al. With f_n and f_t the derivatives of the
pair's energy with respect to r eps and r gamma, the forces +-(f_n N(phi) + f_t T(phi)) on both automata and the torque
(r/2) ((1 + eps) f_t - gamma f_n) on each are exact derivatives of the energy: a rigid motion, however large, costs no energy,
and momentum and angular momentum are conserved to rounding.

Rotations are stored as cos - 1 and sin of half the angle of each automaton. Combined, two half rotations are the mean rotation,
without a square root, and small strains lose no digits. Both ends of a pair get bitwise opposite forces, and so do mirrored
pairs: sums over the links of an automaton add opposite links first.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined
from .lattice import (
    ANGLE,
    COSINE,
    EPS,
    EX,
    EY,
    FIRST_SHARE,
    FIRST_TERM,
    FORCE_X,
    FORCE_Y,
    GAMMA,
    SECOND_SHARE,
    SECOND_TERM,
    SINE,
    TORQUE,
    TURNING,
    X,
    Y,
)

_QUARTER_TURNS = 2.0 / np.pi
# pi / 2 in three parts, the first two short enough that their products with a small whole number are exact (Cody and Waite).
_PART_1, _PART_2, _PART_3 = 1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21


@internal_inlined
def half_angle_rotation(angle):
    """Return cos - 1 and sin of half of `angle`, computed with only +, -, *."""
    half = 0.5 * angle
    quarters = np.rint(half * _QUARTER_TURNS)
    less, sine = small_angle_rotation(((half - quarters * _PART_1) - quarters * _PART_2) - quarters * _PART_3)
    turns = quarters - 4.0 * np.floor(0.25 * quarters)
    # No branches, so that loops vectorise.
    return (
        (less if turns == 0.0 else -sine - 1.0) if turns < 2.0 else (-2.0 - less if turns == 2.0 else sine - 1.0),
        (sine if turns == 0.0 else 1.0 + less) if turns < 2.0 else (-sine if turns == 2.0 else -1.0 - less),
    )


@internal_inlined
def small_angle_rotation(x):
    """Return cos - 1 and sin of an angle of at most pi / 4, to rounding: the polynomials of fdlibm (Sun Microsystems, 1993)."""
    z = x * x
    sine = -1.98412698298579493134e-4 + z * (
        2.75573137070700676789e-6 + z * (-2.50507602534068634195e-8 + z * 1.58969099521155010221e-10)
    )
    less = 2.48015872894767294178e-5 + z * (
        -2.75573143513906633035e-7 + z * (2.08757232129817482790e-9 + z * -1.13596475577881948265e-11)
    )
    sine = -1.66666666666666324348e-1 + z * (8.33333333332248946124e-3 + z * sine)
    less = -0.5 + z * (4.16666666666666019037e-2 + z * (-1.38888888888741095749e-3 + z * less))
    return z * less, x + x * z * sine


@internal
def write_link_strains(body, motion, scratch):
    """Write the half rotations, the strains of all links, and their directions."""
    links, cells, inverse = scratch.links, scratch.cells, 1.0 / body.diameter
    for p in range(motion.shape[1]):
        cells[COSINE, p], cells[SINE, p] = half_angle_rotation(motion[ANGLE, p])
    for q in range(body.layout.offset.size):
        o, nx, ny = body.layout.offset[q], body.normal[q, 0], body.normal[q, 1]
        xj, yj, cosine_j, sine_j = motion[X, o:], motion[Y, o:], cells[COSINE, o:], cells[SINE, o:]
        for p in range(xj.size):
            links[EPS, q, p], links[GAMMA, q, p], links[EX, q, p], links[EY, q, p] = pair_strain(
                (inverse * xj[p] - inverse * motion[X, p], inverse * yj[p] - inverse * motion[Y, p]),
                (cells[COSINE, p], cells[SINE, p]), (cosine_j[p], sine_j[p]), nx, ny,
            )  # fmt: skip


@internal_inlined
def pair_strain(offset, first, second, nx, ny):
    """Return eps, gamma and the direction N(phi) of a pair; `offset` is the difference of its displacements, in diameters."""
    (dx, dy), (ci, si), (cj, sj) = offset, first, second
    less, sine = (ci + cj) + (ci * cj - si * sj), (si + sj) + (ci * sj + cj * si)
    cosine = 1.0 + less
    ex, ey = cosine * nx - sine * ny, cosine * ny + sine * nx
    return less + (dx * ex + dy * ey), (dy * ex - dx * ey) - sine, ex, ey


@internal
def sum_over_links(layout, first, second, sign, out):
    """Write for each automaton a sum over its links: `first` of those that begin, `sign` times `second` of those that end.

    `first` and `second` have the shape (directions, m), `out` has the shape (m,); `sign` is 1 or -1.
    """
    begin, end, offset, sums = layout.begin, layout.end, layout.offset, out[layout.begin : layout.end]
    right, left = first[0, begin:end], second[0, begin - offset[0] : end - offset[0]]
    up, down = first[1, begin:end], second[1, begin - offset[1] : end - offset[1]]
    if offset.size == 2:
        for p in range(sums.size):
            sums[p] = (up[p] + sign * down[p]) + (right[p] + sign * left[p])
    else:
        # In a hexagonal packing, up and down here mean the upper right and the lower left.
        upper_left, lower_right = first[2, begin:end], second[2, begin - offset[2] : end - offset[2]]
        for p in range(sums.size):
            below = sign * down[p] + sign * lower_right[p]
            sums[p] = (below + (up[p] + upper_left[p])) + (right[p] + sign * left[p])


@internal
def sum_by_shares(body, values, links, out):
    """Write for each automaton, shape (m,), the sum of its links' values, shape (directions, m), times the links' shares."""
    for q in range(values.shape[0]):
        for p in range(values.shape[1]):
            links[FIRST_TERM, q, p] = body.links[FIRST_SHARE, q, p] * values[q, p]
            links[SECOND_TERM, q, p] = body.links[SECOND_SHARE, q, p] * values[q, p]
    sum_over_links(body.layout, links[FIRST_TERM], links[SECOND_TERM], 1.0, out)


@internal
def sum_link_forces(body, links, cells):
    """Write the forces and torques of the links on all automata."""
    sum_over_links(body.layout, links[FIRST_TERM], links[FIRST_TERM], -1.0, cells[FORCE_X])
    sum_over_links(body.layout, links[SECOND_TERM], links[SECOND_TERM], -1.0, cells[FORCE_Y])
    sum_over_links(body.layout, links[TURNING], links[TURNING], 1.0, cells[TORQUE])
    radius = 0.5 * body.diameter
    for p in range(cells.shape[1]):
        cells[TORQUE, p] *= radius


@internal_inlined
def equivalent_stress(xx, yy, zz, xy):
    """Return the von Mises equivalent stress [Pa]."""
    squares = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)
    return np.sqrt(0.5 * squares + 3.0 * xy * xy)


@internal_inlined
def virial_stress(normal, tangential, ex, ey):
    """Return the stress xx, yy, xy [Pa] that the tractions on one face contribute, for a face whose share is 1."""
    tx, ty = normal * ex - tangential * ey, normal * ey + tangential * ex
    return ex * tx, ey * ty, 0.5 * (ex * ty + ey * tx)
