"""Equations of motion, as all integrators of the chain share them: forces in the contacts, the ends, the tallies.

A chain is one `table` of numbers. One table instead of many arrays keeps a call from Python cheap, and row numbers instead
of row views keep short chains fast (each view costs as much as several grains). Columns in the long loops are unsigned:
numba must not look for negative indices there, or nothing vectorises.

An end's drive is a number that holds, or `left_pieces` (or the rest) of the rows of `drive`, each (first tick,
coefficients).

Symbols: u displacement, v velocity, d overlap, k contact stiffness, h step, e part of a step, s ticks since a piece of
the drive began.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import inlined, jit
from .laws import placeholders as law
from .laws.placeholders import DISSIPATES, REMEMBERS
from .layout import (
    DISSIPATED,
    FREE,
    GRAINS,
    GRAVITY,
    IMPULSE_LEFT,
    IMPULSE_RIGHT,
    INVERSE_MASS,
    LEFT_DRIVE,
    LEFT_KIND,
    LEFT_MASS,
    LEFT_STATIC,
    LIMIT,
    PEAK,
    PISTON,
    REST_OVERLAP,
    RIGHT_DRIVE,
    RIGHT_KIND,
    RIGHT_MASS,
    RIGHT_STATIC,
    SCALARS,
    SMALLEST_OVERLAP,
    SPEED_LIMIT,
    STEP,
    TALLY,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)

# What `advance` subtracts from its result where a velocity passed its limit, or is not a number.
UNSOUND = 1 << 60
# What an adaptive integrator adds where a tick takes more work than is allowed.
EXHAUSTED = 1 << 61

_ONE = np.uint64(1)
# Sums run in so many lanes: many, where that lets them run as vectors; few, where joining the lanes would cost more.
_FEW_LANES, _MANY_LANES, _MANY_GRAINS = 8, 256, 2048


@inlined
def overlap(a, u, j):
    """Return the overlap of contact j, displacements in row u; negative where there is a gap."""
    return a[u, j] - a[u, j + 1] + a[REST_OVERLAP, j]


@inlined
def pressed(d):
    """Return the overlap of a contact that is pressed, 0 of one that is open. NaN stays NaN."""
    return 0.0 if d < SMALLEST_OVERLAP else d


@inlined
def contact(a, u, j):
    """Return the elastic force in contact j."""
    return law.force(a, j, pressed(overlap(a, u, j)))


@jit
def contact_forces(a, u, v, out):
    """Write the forces in all contacts, dissipation included, into an array of its own, shape (n + 1,)."""
    for j in range(int(a[SCALARS, GRAINS]) + 1):
        out[j], _ = _force(a, u, v, j)


@jit
def contact_force(a, u, v, j):
    """Return the force in contact j alone, with the bits that `contact_forces` gives it."""
    f, _ = _force(a, u, v, np.uint64(j))
    return f


@inlined
def _force(a, u, v, j):
    """Return the whole force of a contact, never a pull, and the power that it turns into heat."""
    d = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j]
    f = law.force(a, j, pressed(d))
    if not DISSIPATES:
        return f, 0.0
    speed = a[v, j] - a[v, j + _ONE]
    total = f + (law.coefficient(a, j, pressed(d)) if d > 0.0 else 0.0) * speed
    total = 0.0 if total < 0.0 else total
    return total, (total - f) * speed


@jit
def begin_histories(a):
    """Write the histories of contacts that were never loaded, and no losses."""
    for j in range(int(a[SCALARS, GRAINS]) + 1):
        law.begin(a, j)
        a[DISSIPATED, j] = 0.0


@jit
def remember(a, u):
    """Note what the step has changed in the contacts' histories, and what that has cost; displacements in row u."""
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        law.remember(a, j, pressed(a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j]))


@inlined
def add(total, x):
    """Compensated summation (Kahan): (sum, compensation) -> the same with x added."""
    y = x - total[1]
    t = total[0] + y
    return t, (t - total[0]) - y


@inlined
def tally(a, place):
    """Return a compensated sum of the tally."""
    return a[TALLY, place], a[TALLY, place + 1]


@inlined
def keep(a, place, total):
    """Put a compensated sum back into the tally."""
    a[TALLY, place], a[TALLY, place + 1] = total


@jit
def piece_at(drive, first, last, tick):
    """Return the row in first..last-1 whose piece is in force at a tick; first - 1 before the first piece begins."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if drive[middle, 0] <= tick:
            low = middle + 1
        else:
            high = middle
    return low - 1


@inlined
def next_piece(drive, piece, last, tick):
    """`piece_at` one tick on, where the piece of the tick before is known."""
    while piece + 1 < last and drive[piece + 1, 0] <= tick:
        piece += 1
    return piece


@inlined
def recentre(a, row, drive, piece, first, number, tick):
    """Write the drive's polynomial about a tick, in steps, into a row; return its length. Before any piece: `number`."""
    if piece < first:
        a[row, 0] = number
        return 1
    n = drive.shape[1] - 1
    while n > 1 and drive[piece, n] == 0.0:
        n -= 1
    for i in range(n):
        a[row, i] = drive[piece, i + 1]
    s = tick - drive[piece, 0]
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            a[row, j] += s * a[row, j + 1]
    return n


@inlined
def value(a, row, n, e):
    """Return the value of a re-centred polynomial a part e of a step after the tick."""
    p = 0.0
    for i in range(n - 1, -1, -1):
        p = p * e + a[row, i]
    return p


@inlined
def integral(a, row, n, e):
    """Return a profile's integral from the tick to e, in steps."""
    p = 0.0
    for i in range(n - 1, -1, -1):
        p = p * e + a[row, i] / (i + 1)
    return p * e


@jit
def turn(a, drive, left_pieces, left_piece, right_piece, left, right, tick):
    """Return the pieces in force at a tick, the lengths of their re-centred polynomials, and a mark of this pair of pieces."""
    left_piece = next_piece(drive, left_piece, left_pieces, tick)
    right_piece = next_piece(drive, right_piece, drive.shape[0], tick)
    n_left = recentre(a, LEFT_DRIVE, drive, left_piece, 0, left, tick)
    n_right = recentre(a, RIGHT_DRIVE, drive, right_piece, left_pieces, right, tick)
    mark = piece_mark(drive, left_piece, 0, left), piece_mark(drive, right_piece, left_pieces, right)
    return left_piece, right_piece, n_left, n_right, mark


@jit
def piece_mark(drive, piece, first, number):
    """Return a number that differs between pieces that differ: integrators with a memory start anew where it changes."""
    mark = number
    if piece >= first:
        for i in range(drive.shape[1]):
            mark = mark * 1.6180339887498949 + drive[piece, i]
    return mark


@jit
def accelerations(a, u, v, left_force, right_force, out):
    """Write accelerations into row `out`; return the forces in the outermost contacts 0, 1, n - 1, n, and the power lost."""
    n, gravity = int(a[SCALARS, GRAINS]), a[SCALARS, GRAVITY]
    f, loss = _force(a, u, v, np.uint64(0))
    f0 = f
    f1, _ = _force(a, u, v, np.uint64(1))
    fm, _ = _force(a, u, v, np.uint64(n - 1))
    f += left_force
    for i in range(np.uint64(1), np.uint64(n)):
        g, lost = _force(a, u, v, i)
        a[out, i] = a[INVERSE_MASS, i] * (f - g) + gravity
        loss += lost
        f = g
    g, lost = _force(a, u, v, np.uint64(n))
    a[out, n] = a[INVERSE_MASS, n] * (f - (g - right_force)) + gravity
    return f0, f1, fm, g, loss + lost


@jit
def derivative(a, u, v, n_left, n_right, e, out):
    """dv/dt at a part e of a step into row `out`; behind the chain the powers and thrusts of the ends, and the power lost."""
    n = int(a[SCALARS, GRAINS])
    left_kind, right_kind = a[SCALARS, LEFT_KIND], a[SCALARS, RIGHT_KIND]
    left, right = value(a, LEFT_DRIVE, n_left, e), value(a, RIGHT_DRIVE, n_right, e)
    left_force = a[SCALARS, LEFT_STATIC] + left if left_kind == FREE else 0.0
    right_force = right - a[SCALARS, RIGHT_STATIC] if right_kind == FREE else 0.0
    f0, f1, fm, fn, loss = accelerations(a, u, v, left_force, right_force, out)
    a[out, n + 2], a[out, n + 3], a[out, n + 4], a[out, n + 5], a[out, n + 6] = 0.0, 0.0, f0, -fn, loss
    if left_kind == FREE:
        a[out, n + 2], a[out, n + 4] = left_force * a[v, 1], left_force
    elif left_kind == PISTON:
        a[out, n + 2], a[out, n + 4] = f1 * left, f1
    if right_kind == FREE:
        a[out, n + 3], a[out, n + 5] = right_force * a[v, n], right_force
    elif right_kind == PISTON:
        a[out, n + 3], a[out, n + 5] = -fm * right, -fm


@jit
def place_pistons(a, u, v, n_left, n_right, left_base, right_base, e):
    """Put prescribed grains where they are a part e of a step after the tick: the drive's integral, exactly."""
    n, h = int(a[SCALARS, GRAINS]), a[SCALARS, STEP]
    if a[SCALARS, LEFT_KIND] == PISTON:
        a[u, 1] = left_base + h * integral(a, LEFT_DRIVE, n_left, e)
        a[v, 1] = value(a, LEFT_DRIVE, n_left, e)
    if a[SCALARS, RIGHT_KIND] == PISTON:
        a[u, n] = right_base + h * integral(a, RIGHT_DRIVE, n_right, e)
        a[v, n] = value(a, RIGHT_DRIVE, n_right, e)


@jit
def finish(a, left_before, right_before):
    """Finish a step for integrators without tallies of their own; return whether an overlap, and a velocity, passed its limit.

    What changes a prescribed grain's own velocity is work and impulse too.
    """
    n = int(a[SCALARS, GRAINS])
    if a[SCALARS, LEFT_KIND] == PISTON:
        tally_piston(a, a[SCALARS, LEFT_MASS], left_before, a[V, 1], WORK_LEFT, IMPULSE_LEFT)
    if a[SCALARS, RIGHT_KIND] == PISTON:
        tally_piston(a, a[SCALARS, RIGHT_MASS], right_before, a[V, n], WORK_RIGHT, IMPULSE_RIGHT)
    if REMEMBERS:
        remember(a, U)
    passed = False
    for j in range(np.uint64(0), np.uint64(n + 1)):
        d = a[U, j] - a[U, j + _ONE] + a[REST_OVERLAP, j]
        d = 0.0 if d < SMALLEST_OVERLAP else d
        p = a[PEAK, j]
        a[PEAK, j] = d if d > p else p
        passed |= not (d <= a[LIMIT, j])
    fastest, unsound = a[SCALARS, SPEED_LIMIT], False
    for i in range(np.uint64(1), np.uint64(n + 1)):
        unsound |= not (abs(a[V, i]) <= fastest)
    return passed, unsound


@jit
def tally_piston(a, mass, before, after, work, impulse):
    """Work and impulse that take a prescribed grain from one velocity to another."""
    keep(a, work, add(tally(a, work), 0.5 * mass * (after - before) * (after + before)))
    keep(a, impulse, add(tally(a, impulse), mass * (after - before)))


@jit
def outcome(ticks, passed, unsound):
    """Return the ticks done as `advance` does: negative if an overlap passed its limit, far below 0 if a velocity did."""
    if unsound:
        return -ticks - UNSOUND
    return -ticks if passed else ticks


@jit
def energies(a, mass):
    """Kinetic energy, elastic energy, momentum: each in lanes, with compensation, then the lanes in their order.

    The lanes make the order of the sums fixed and let them run as vectors.
    """
    n = int(a[SCALARS, GRAINS])
    width = _FEW_LANES if n < _MANY_GRAINS else _MANY_LANES
    lanes = np.zeros((6, width))
    for j in range(0, n + 1, width):
        _add_potential(a, lanes, j, min(width, n + 1 - j))
    for i in range(0, n, width):
        _add_motion(a, mass, lanes, i, min(width, n - i))
    kinetic, potential, momentum = (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)
    for lane in range(width):
        kinetic = add(add(kinetic, lanes[0, lane]), -lanes[1, lane])
        potential = add(add(potential, lanes[2, lane]), -lanes[3, lane])
        momentum = add(add(momentum, lanes[4, lane]), -lanes[5, lane])
    return kinetic[0], potential[0], momentum[0]


@jit
def _add_potential(a, lanes, begin, count):
    for lane in range(np.uint64(count)):
        j = np.uint64(begin) + lane
        stored = law.energy(a, j, pressed(a[U, j] - a[U, j + _ONE] + a[REST_OVERLAP, j]))
        lanes[2, lane], lanes[3, lane] = add((lanes[2, lane], lanes[3, lane]), stored)


@jit
def _add_motion(a, mass, lanes, begin, count):
    for lane in range(np.uint64(count)):
        i = np.uint64(begin) + lane
        v = a[V, i + _ONE]
        lanes[0, lane], lanes[1, lane] = add((lanes[0, lane], lanes[1, lane]), 0.5 * mass[i] * (v * v))
        lanes[4, lane], lanes[5, lane] = add((lanes[4, lane], lanes[5, lane]), mass[i] * v)
