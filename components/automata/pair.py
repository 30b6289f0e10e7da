"""The kinematics of a pair of linked automata: strains that no rigid motion changes, and the forces that belong to them.

The way from centre to centre, d, is seen from axes that are turned by the mean phi of both rotations. With N the direction to
the neighbour before anything moved and T that turned by 90 degrees, the strains are

    eps = d . N(phi) / r - 1,        gamma = d . T(phi) / r,

for small motions du.n/r and du.t/r - (w_i + w_j)/2 of the movable cellular automata. With f_n and f_t the derivatives of the
energy of the pair with respect to r eps and r gamma, the forces +-(f_n N(phi) + f_t T(phi)) on both and the torque
(r/2) ((1 + eps) f_t - gamma f_n) on each are its exact derivatives: a rigid motion, however large, costs no energy, and
momentum and angular momentum are conserved to rounding.

Rotations are kept as cos - 1 and sin of half the angle of each automaton, so that their product is the mean rotation of a pair
without a root, and small strains lose no digits. Both ends of a pair compute the same bits with opposite signs, and so do pairs
that are mirrored.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal_inlined, jit

_QUARTER_TURNS = 2.0 / np.pi
# pi / 2 in three parts, the first two so short that their products with a small whole number are exact (Cody and Waite).
_PART_1, _PART_2, _PART_3 = 1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21


@jit
def orient(rotation, half_out, begin, end):
    """Write cos - 1 and sin of half the rotations, with + - x alone, for automata from `begin` up to `end`.

    Args:
        rotation: shape (n,) [rad].
        half_out: shape (n, 2).
        begin: first automaton.
        end: after the last one.
    """
    for i in range(begin, end):
        half_out[i, 0], half_out[i, 1] = half_turn(rotation[i])


@internal_inlined
def half_turn(angle):
    """Return cos - 1 and sin of half an angle."""
    half = 0.5 * angle
    quarters = np.rint(half * _QUARTER_TURNS)
    less, sine = small_turn(((half - quarters * _PART_1) - quarters * _PART_2) - quarters * _PART_3)
    turns = quarters - 4.0 * np.floor(0.25 * quarters)
    # Without branches, so that loops are made of vectors.
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


@internal_inlined
def strains(displacement, half, i, j, nx, ny, length):
    """Return the strains along and across a pair, and cos - 1 and sin of its mean rotation.

    Args:
        displacement: shape (n, 2) [m].
        half: see `orient`, shape (n, 2).
        i: the automaton.
        j: its neighbour; i itself where there is none, which gives finite numbers.
        nx: direction from i to j before anything moved, x.
        ny: the same, y.
        length: distance of the two before anything moved [m].
    """
    dx, dy = displacement[j, 0] - displacement[i, 0], displacement[j, 1] - displacement[i, 1]
    ci, si, cj, sj, inverse = half[i, 0], half[i, 1], half[j, 0], half[j, 1], 1.0 / length
    less, sine = (ci + cj) + (ci * cj - si * sj), (si + sj) + (ci * sj + cj * si)
    x, y = dx + (less * dx + sine * dy), dy + (less * dy - sine * dx)
    return (x * nx + y * ny) * inverse + less, (y * nx - x * ny) * inverse - sine, less, sine


@jit
def largest_strain(body, displacement, half):
    """Return the largest strain along or across a pair of neighbours; arguments as for `strains`."""
    largest = 0.0
    for i in range(body.kind.size):
        for slot in range(body.directions.shape[0] // 2):
            nx, ny = body.directions[slot, 0], body.directions[slot, 1]
            eps, gamma, _, _ = strains(displacement, half, i, body.neighbours[i, slot], nx, ny, body.diameter)
            if body.neighbours[i, slot] != i:
                largest = max(largest, abs(eps), abs(gamma))
    return largest


@jit
def mark_strained(body, displacement, half, limit, marked):
    """Mark the automata with a neighbour towards which the strain along or across exceeds a limit, shape (n,), in place."""
    for i in range(body.kind.size):
        for slot in range(body.directions.shape[0] // 2):
            j, nx, ny = body.neighbours[i, slot], body.directions[slot, 0], body.directions[slot, 1]
            eps, gamma, _, _ = strains(displacement, half, i, j, nx, ny, body.diameter)
            if j != i and not (abs(eps) <= limit and abs(gamma) <= limit):
                marked[i] = marked[j] = True


@internal_inlined
def mirrored_slots(slots, group):
    """Return two slots that a mirror exchanges or keeps: 0 and 2, 1 and 3; or 0 and 3, 1 and 2, 4 and 5."""
    if slots == 4:
        return group, group + 2
    if group == 0:
        return 0, 3
    return (1, 2) if group == 1 else (4, 5)


@internal_inlined
def turned(fn, ft, nx, ny, less, sine):
    """Return a force, x and y, from its parts along and across a pair."""
    x, y = fn * nx - ft * ny, fn * ny + ft * nx
    return x + (less * x - sine * y), y + (less * y + sine * x)
