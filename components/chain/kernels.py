"""What all integrators of the chain share: the memory's layout, Hertz's law, the ends, the tallies.

Grains have indices 1..n in rows of width >= n + 6; 0 and n + 1 are the walls, which do not move. Contact j is between grains j and j + 1.
Symbols: u displacement, v velocity, d overlap, k contact stiffness, m mass, h step, s ticks since a piece of the drive began.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..jit import jit

# Rows of the state. The four columns behind the chain's in V hold work and impulse of the ends (left work, right work, left impulse,
# right impulse) for integrators that carry them as unknowns of their own.
U, V, PEAK = 0, 1, 2
STATE_ROWS = 3

# Places in the tally that precedes the rows: compensated sums (value, compensation), and what was there at the reset.
WORK_LEFT, WORK_RIGHT, IMPULSE_LEFT, IMPULSE_RIGHT = 0, 2, 4, 6
START_ENERGY, START_MOMENTUM = 8, 9
HISTORY_LENGTH, HISTORY_DRIVE = 10, 11
TALLY = 16

# Rows of the constants.
STIFFNESS, REST, INVERSE_MASS, LIMIT, SCALARS = 0, 1, 2, 3, 4
CONSTANT_ROWS = 5
# Columns of the row SCALARS.
STEP, LEFT_KIND, RIGHT_KIND, LEFT_MASS, RIGHT_MASS, STATIC_FORCE, SPEED_LIMIT, TOLERANCE, GRAINS = range(9)
# Kinds of an end.
FREE, PISTON, WALL = 0, 1, 2

# Scratch rows that hold the drive's polynomials, re-centred at the present tick.
LEFT_DRIVE, RIGHT_DRIVE = 0, 1
DRIVE_ROWS = 2

# Overlaps below this count as open: their forces would be denormal numbers, which are slow.
SMALLEST_OVERLAP = 1e-150


def row_width(grains: int) -> int:
    """Columns of a row: the grains, two walls, four tallies; at least what the drive's polynomials need."""
    return max(40, -(-(grains + 6) // 8) * 8)


@jit
def hertz(d, k):
    """F = k d^1.5 for d > 0, else 0: no tension (1.1). NaN stays NaN."""
    d = 0.0 if d < SMALLEST_OVERLAP else d
    return k * (d * sqrt(d))


@jit
def accumulate(tally, place, x):
    """Compensated summation (Kahan) into tally[place]."""
    y = x - tally[place + 1]
    t = tally[place] + y
    tally[place + 1] = (t - tally[place]) - y
    tally[place] = t


@jit
def added(total, x):
    """`accumulate` for a sum kept in registers: (sum, compensation) -> the same with x added."""
    y = x - total[1]
    t = total[0] + y
    return t, (t - total[0]) - y


@jit
def piece_at(drive, first, last, tick):
    """The row in first..last-1 whose piece is in force at a tick; first - 1 before the first piece begins."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if drive[middle, 0] <= tick:
            low = middle + 1
        else:
            high = middle
    return low - 1


@jit
def next_piece(drive, piece, last, tick):
    """`piece_at` one tick on, where the piece of the tick before is known."""
    while piece + 1 < last and drive[piece + 1, 0] <= tick:
        piece += 1
    return piece


@jit
def recentre(drive, piece, first, tick, out):
    """Write the coefficients of the drive's polynomial about a tick, in steps; returns their number."""
    if piece < first:
        out[0] = 0.0
        return 1
    n = drive.shape[1] - 1
    while n > 1 and drive[piece, n] == 0.0:
        n -= 1
    for i in range(n):
        out[i] = drive[piece, i + 1]
    s = tick - drive[piece, 0]
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            out[j] += s * out[j + 1]
    return n


@jit
def value(c, n, e):
    """The re-centred polynomial a part e of a step after the tick."""
    p = 0.0
    for i in range(n - 1, -1, -1):
        p = p * e + c[i]
    return p


@jit
def integral(c, n, e):
    """Its integral from the tick to e, in steps."""
    p = 0.0
    for i in range(n - 1, -1, -1):
        p = p * e + c[i] / (i + 1)
    return p * e


@jit
def accelerations(u, constants, left_force, right_force, a_out):
    """Accelerations of grains 1..n, and the forces in the outermost contacts 0, 1, n - 1, n."""
    k, r, w = constants[STIFFNESS], constants[REST], constants[INVERSE_MASS]
    n = int(constants[SCALARS, GRAINS])
    f = hertz(u[0] - u[1] + r[0], k[0])
    f0, f1, fm = f, 0.0, f
    f += left_force
    for i in range(1, n + 1):
        g = hertz(u[i] - u[i + 1] + r[i], k[i])
        if i == 1:
            f1 = g
        if i == n - 1:
            fm = g
        net = f - (g - right_force) if i == n else f - g
        a_out[i] = w[i] * net
        f = g
    return f0, f1, fm, f


@jit
def derivative(u, v, constants, scratch, n_left, n_right, e, a_out):
    """dv/dt at a part e of a step; behind the chain the powers and thrusts of the two ends, dW/dt and dI/dt."""
    n = int(constants[SCALARS, GRAINS])
    left_kind, right_kind = constants[SCALARS, LEFT_KIND], constants[SCALARS, RIGHT_KIND]
    left, right = value(scratch[LEFT_DRIVE], n_left, e), value(scratch[RIGHT_DRIVE], n_right, e)
    static = constants[SCALARS, STATIC_FORCE]
    left_force = static + left if left_kind == FREE else 0.0
    right_force = right - static if right_kind == FREE else 0.0
    f0, f1, fm, fn = accelerations(u, constants, left_force, right_force, a_out)
    a_out[n + 2], a_out[n + 3], a_out[n + 4], a_out[n + 5] = 0.0, 0.0, f0, -fn
    if left_kind == FREE:
        a_out[n + 2], a_out[n + 4] = left_force * v[1], left_force
    elif left_kind == PISTON:
        a_out[n + 2], a_out[n + 4] = f1 * left, f1
    if right_kind == FREE:
        a_out[n + 3], a_out[n + 5] = right_force * v[n], right_force
    elif right_kind == PISTON:
        a_out[n + 3], a_out[n + 5] = -fm * right, -fm


@jit
def place_pistons(u, v, constants, scratch, n_left, n_right, left_base, right_base, e):
    """Put prescribed grains where they are a part e of a step after the tick: the drive's integral, exactly."""
    n = int(constants[SCALARS, GRAINS])
    h = constants[SCALARS, STEP]
    if constants[SCALARS, LEFT_KIND] == PISTON:
        u[1] = left_base + h * integral(scratch[LEFT_DRIVE], n_left, e)
        v[1] = value(scratch[LEFT_DRIVE], n_left, e)
    if constants[SCALARS, RIGHT_KIND] == PISTON:
        u[n] = right_base + h * integral(scratch[RIGHT_DRIVE], n_right, e)
        v[n] = value(scratch[RIGHT_DRIVE], n_right, e)


@jit
def tally_piston(tally, mass, before, after, work_place, impulse_place):
    """Work and impulse that change a prescribed grain's own velocity."""
    if after != before:
        accumulate(tally, work_place, 0.5 * mass * (after - before) * (after + before))
        accumulate(tally, impulse_place, mass * (after - before))


@jit
def tally_pistons(tally, constants, v, left_before, right_before):
    """`tally_piston` for both ends, once a step."""
    n = int(constants[SCALARS, GRAINS])
    if constants[SCALARS, LEFT_KIND] == PISTON:
        tally_piston(tally, constants[SCALARS, LEFT_MASS], left_before, v[1], WORK_LEFT, IMPULSE_LEFT)
    if constants[SCALARS, RIGHT_KIND] == PISTON:
        tally_piston(tally, constants[SCALARS, RIGHT_MASS], right_before, v[n], WORK_RIGHT, IMPULSE_RIGHT)


@jit
def parts(memory, rows, width):
    """Tally and rows of a component's memory."""
    return memory[:TALLY], memory[TALLY : TALLY + rows * width].reshape((rows, width))


@jit
def finish(tally, state, constants, left_before, right_before):
    """The end of a step for integrators that keep no tallies themselves; True where a limit was passed."""
    tally_pistons(tally, constants, state[V], left_before, right_before)
    return note_peaks(state[U], constants, state[PEAK])


@jit
def note_peaks(u, constants, peak):
    """Keep the largest overlap of each contact; True where one is above its limit or not a number."""
    n = int(constants[SCALARS, GRAINS])
    r, limit = constants[REST], constants[LIMIT]
    passed = False
    for j in range(n + 1):
        d = u[j] - u[j + 1] + r[j]
        d = 0.0 if d < SMALLEST_OVERLAP else d
        peak[j] = d if d > peak[j] else peak[j]
        passed |= not (d <= limit[j])
    return passed


@jit
def turn(drive, left_pieces, left_piece, right_piece, tick, scratch):
    """The pieces in force at a tick, their polynomials re-centred there, and a mark that tells one pair of pieces from another."""
    left_piece = next_piece(drive, left_piece, left_pieces, tick)
    right_piece = next_piece(drive, right_piece, drive.shape[0], tick)
    n_left = recentre(drive, left_piece, 0, tick, scratch[LEFT_DRIVE])
    n_right = recentre(drive, right_piece, left_pieces, tick, scratch[RIGHT_DRIVE])
    mark = piece_mark(drive, left_piece, 0) + 3.0 * piece_mark(drive, right_piece, left_pieces)
    return left_piece, right_piece, n_left, n_right, mark


@jit
def piece_mark(drive, piece, first):
    """A number that differs between pieces that differ: integrators with a memory start anew where it changes."""
    mark = 0.0
    if piece >= first:
        for i in range(drive.shape[1]):
            mark = mark * 1.6180339887498949 + drive[piece, i]
    return mark


@jit
def unsound(state, constants):
    """True where a velocity is above its limit, or a velocity or displacement is not finite."""
    n = int(constants[SCALARS, GRAINS])
    fastest = constants[SCALARS, SPEED_LIMIT]
    v, u = state[V][1 : n + 1], state[U][1 : n + 1]
    bad = False
    for i in range(n):
        bad |= not (abs(v[i]) <= fastest)
        bad |= not (abs(u[i]) <= 1e300)
    return bad


@jit
def energies(state, constants, mass, k, out):
    """Kinetic and potential energy and momentum, each summed in the order of the grains with compensation."""
    n = int(constants[SCALARS, GRAINS])
    sums = np.zeros(6)
    u, v, r = state[U], state[V], constants[REST]
    for j in range(n + 1):
        d = u[j] - u[j + 1] + r[j]
        if d > 0.0 and k[j] > 0.0:
            accumulate(sums, 2, 0.4 * k[j] * (d * d * sqrt(d)))
    for i in range(1, n + 1):
        accumulate(sums, 0, 0.5 * mass[i - 1] * (v[i] * v[i]))
        accumulate(sums, 4, mass[i - 1] * v[i])
    out[0], out[1], out[2] = sums[0], sums[2], sums[4]
