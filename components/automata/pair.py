"""Pairs of linked automata: the strains that no rigid motion changes, and the forces that belong to them.

The way from centre to centre, d, is seen from axes that are turned by the mean phi of both rotations. With N the direction to
the neighbour before anything moved and T that turned by 90 degrees, the strains are

    eps = d . N(phi) / r - 1,        gamma = d . T(phi) / r,

for small motions du.n/r and du.t/r - (w_i + w_j)/2 of the movable cellular automata. With f_n and f_t the derivatives of the
energy of the pair with respect to r eps and r gamma, the forces +-(f_n N(phi) + f_t T(phi)) on both and the torque
(r/2) ((1 + eps) f_t - gamma f_n) on each are its exact derivatives: a rigid motion, however large, costs no energy, and
momentum and angular momentum are conserved to rounding.

Rotations are kept as cos - 1 and sin of half the angle of each automaton, so that their product is the mean rotation of a pair
without a root, and small strains lose no digits. Both ends of a pair get the same bits with opposite signs, and so do pairs
that are mirrored: sums over the links of an automaton add opposite links first.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined, jit

_QUARTER_TURNS = 2.0 / np.pi
# pi / 2 in three parts, the first two so short that their products with a small whole number are exact (Cody and Waite).
_PART_1, _PART_2, _PART_3 = 1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21


@internal_inlined
def half_turn(angle):
    """Return cos - 1 and sin of half an angle, with + - x alone."""
    half = 0.5 * angle
    quarters = np.rint(half * _QUARTER_TURNS)
    less, sine = small_turn(((half - quarters * _PART_1) - quarters * _PART_2) - quarters * _PART_3)
    turns = quarters - 4.0 * np.floor(0.25 * quarters)
    # Without branches, so that loops vectorise.
    return (
        (less if turns == 0.0 else -sine - 1.0) if turns < 2.0 else (-2.0 - less if turns == 2.0 else sine - 1.0),
        (sine if turns == 0.0 else 1.0 + less) if turns < 2.0 else (-sine if turns == 2.0 else -1.0 - less),
    )


@internal_inlined
def small_turn(x):
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
def orient(angle, cosine, sine):
    """Write cos - 1 and sin of half the rotations."""
    for p in range(angle.size):
        cosine[p], sine[p] = half_turn(angle[p])


@internal
def strain_links(body, motion, scratch):
    """Write the half rotations, the strains of all links, and their directions.

    Args:
        body: a `lattice.Body`.
        motion: a `lattice.Motion`.
        scratch: a `lattice.Scratch`.
    """
    orient(motion.angle, scratch.forces.cosine, scratch.forces.sine)
    places, links = (motion.x, motion.y, scratch.forces.cosine, scratch.forces.sine), scratch.links
    for q in range(body.layout.offset.size):
        o = body.layout.offset[q]
        end = motion.x.size - o
        first = (places[0][:end], places[1][:end], places[2][:end], places[3][:end])
        second = (places[0][o:], places[1][o:], places[2][o:], places[3][o:])
        strains, direction = (links.eps[q, :end], links.gamma[q, :end]), (links.ex[q, :end], links.ey[q, :end])
        _strain(first, second, body.normal[q, 0], body.normal[q, 1], 1.0 / body.diameter, strains, direction)


@jit
def measure_pairs(body, motion, scratch):
    """Call `strain_links` from Python."""
    strain_links(body, motion, scratch)


@internal
def _strain(first, second, nx, ny, inverse, strains, direction):
    """Write strains and directions of links between automata, each given by x, y, cos - 1 and sin of half its rotation."""
    (xi, yi, cosine_i, sine_i), (xj, yj, cosine_j, sine_j) = first, second
    (eps, gamma), (ex, ey) = strains, direction
    for p in range(eps.size):
        eps[p], gamma[p], ex[p], ey[p] = pair_strain(
            (inverse * xj[p] - inverse * xi[p], inverse * yj[p] - inverse * yi[p]),
            (cosine_i[p], sine_i[p]), (cosine_j[p], sine_j[p]), nx, ny,
        )  # fmt: skip


@internal_inlined
def pair_strain(way, first, second, nx, ny):
    """Return eps, gamma and the direction N(phi) of a pair, with the difference of the displacements in diameters."""
    (dx, dy), (ci, si), (cj, sj) = way, first, second
    less, sine = (ci + cj) + (ci * cj - si * sj), (si + sj) + (ci * sj + cj * si)
    cosine = 1.0 + less
    ex, ey = cosine * nx - sine * ny, cosine * ny + sine * nx
    return less + (dx * ex + dy * ey), (dy * ex - dx * ey) - sine, ex, ey


@internal
def sum_over_links(body, first, second, sign, out):
    """Write sums over the links of all automata: of `first` where links begin, and of `sign` times `second` where they end.

    Args:
        body: a `lattice.Body`.
        first: shape (directions, m).
        second: likewise.
        sign: 1 or -1.
        out: shape (m,).
    """
    begin, end, offset = body.layout.begin, body.layout.end, body.layout.offset
    o0, o1 = offset[0], offset[1]
    right, left = first[0, begin:end], second[0, begin - o0 : end - o0]
    up, down = first[1, begin:end], second[1, begin - o1 : end - o1]
    if offset.size == 2:
        _sum_square(right, left, up, down, sign, out[begin:end])
    else:
        o2 = offset[2]
        _sum_hexagonal((right, left), (up, down), (first[2, begin:end], second[2, begin - o2 : end - o2]), sign, out[begin:end])


@internal
def _sum_square(right, left, up, down, sign, out):
    for p in range(out.size):
        out[p] = (up[p] + sign * down[p]) + (right[p] + sign * left[p])


@internal
def _sum_hexagonal(row, rising, falling, sign, out):
    (right, left), (upper_right, lower_left), (upper_left, lower_right) = row, rising, falling
    for p in range(out.size):
        below = sign * lower_left[p] + sign * lower_right[p]
        out[p] = (below + (upper_right[p] + upper_left[p])) + (right[p] + sign * left[p])


@internal
def share_out(first_share, second_share, values, first, second):
    """Write what values of links, shape (m,), add to sums at both of their ends."""
    for p in range(values.size):
        first[p], second[p] = first_share[p] * values[p], second_share[p] * values[p]


@internal
def sum_shares(body, values, links, out):
    """Write the sums of values of links, shape (directions, m), by their shares in both automata, shape (m,)."""
    for q in range(body.layout.offset.size):
        share_out(body.first_share[q], body.second_share[q], values[q], links.first[q], links.second[q])
    sum_over_links(body, links.first, links.second, 1.0, out)


@internal
def sum_forces(body, links, forces):
    """Write the forces and torques of the links on all automata."""
    sum_over_links(body, links.first, links.first, -1.0, forces.x)
    sum_over_links(body, links.second, links.second, -1.0, forces.y)
    sum_over_links(body, links.torque, links.torque, 1.0, forces.torque)
    radius = 0.5 * body.diameter
    for p in range(forces.torque.size):
        forces.torque[p] *= radius


@internal
def dilate(body, values, scratch):
    """Write the volumetric strains, from the strains of links that count, shape (directions, m)."""
    theta, stiffening = scratch.forces.dilation, scratch.forces.stiffening
    sum_shares(body, values, scratch.links, theta)
    for p in range(theta.size):
        theta[p] *= stiffening[p]


@internal_inlined
def equivalent_stress(xx, yy, zz, xy):
    """Return von Mises' equivalent stress [Pa]."""
    squares = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)
    return np.sqrt(0.5 * squares + 3.0 * xy * xy)


@internal_inlined
def virial(normal, tangential, ex, ey):
    """Return what tractions on a face add to the stress, for a share of 1: xx, yy and xy [Pa]."""
    tx, ty = normal * ex - tangential * ey, normal * ey + tangential * ex
    return ex * tx, ey * ty, 0.5 * (ex * ty + ey * tx)
