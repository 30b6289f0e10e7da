"""Symplectic compositions of drifts (u += c h v) and kicks (v += b h a): PEFRL and leapfrog.

PEFRL: I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188, eq. (20): order 4, four forces a step.
Leapfrog (position Verlet): order 2, one force a step.

Work and impulse of the ends are advanced by the exact flow of each kick, so they have the order of the scheme.

A step reads displacements from one row and writes them to another (a loop in place does not vectorise), velocities in place. A range of
grains can be advanced through many stages before its neighbours are (`advance` does so for chains that do not fit the cache): the range
moves one grain to the left with every stage, so whatever a stage reads has been written by the stage before it. Tiled or not, each
grain's arithmetic is the same, and so are the bits.
"""

from __future__ import annotations

from math import sqrt

from ...jit import jit
from .. import kernels
from ..kernels import (
    FREE,
    GRAINS,
    IMPULSE_LEFT,
    IMPULSE_RIGHT,
    INVERSE_MASS,
    LEFT_DRIVE,
    LEFT_KIND,
    LEFT_MASS,
    LIMIT,
    PEAK,
    PISTON,
    REST,
    RIGHT_DRIVE,
    RIGHT_KIND,
    RIGHT_MASS,
    SCALARS,
    SMALLEST_OVERLAP,
    STATE_ROWS,
    STATIC_FORCE,
    STEP,
    STIFFNESS,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)

_XI, _LAMBDA, _CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
_PEFRL_DRIFTS = (_XI, _CHI, 1.0 - 2.0 * (_CHI + _XI), _CHI, _XI)
_PEFRL_KICKS = ((1.0 - 2.0 * _LAMBDA) / 2.0, _LAMBDA, _LAMBDA, (1.0 - 2.0 * _LAMBDA) / 2.0)
# The part of the step that has passed when each kick falls.
_PEFRL_PASSED = (_XI, _XI + _CHI, 1.0 - (_XI + _CHI), 1.0 - _XI)
_LEAPFROG_DRIFTS, _LEAPFROG_KICKS, _LEAPFROG_PASSED = (0.5, 0.5), (1.0,), (0.5,)

# Chains longer than this are advanced tile by tile: rows of 32768 grains fill a second-level cache.
TILED_ABOVE = 24_576
_TILE_GRAINS = 4096
_BLOCK_STAGES = 128

SCRATCH_ROWS = kernels.DRIVE_ROWS + 1
_OTHER_U = kernels.DRIVE_ROWS


@jit
def _kick_and_drift(u, u_out, v, k, r, w, kick, drift, f, low, high):
    """Grains low..high-1: v += kick (f_left - f_right) / m, u_out = u + drift v; f enters as the force left of `low`, returns the next."""
    ui, uj, vi, ki, ri, wi, out = u[low:high], u[low + 1 : high + 1], v[low:high], k[low:high], r[low:high], w[low:high], u_out[low:high]
    for i in range(high - low):
        d = ui[i] - uj[i] + ri[i]
        d = 0.0 if d < SMALLEST_OVERLAP else d
        g = ki[i] * (d * sqrt(d))
        x = vi[i] + (kick * wi[i]) * (f - g)
        vi[i] = x
        out[i] = ui[i] + drift * x
        f = g
    return f


@jit
def _kick_and_drift_watched(u, u_out, v, k, r, w, peak, limit, kick, drift, f, low, high):
    """The same bits, and the peaks kept: once a step. Returns whether an overlap is above its limit, and the force."""
    ui, uj, vi, ki, ri, wi, out = u[low:high], u[low + 1 : high + 1], v[low:high], k[low:high], r[low:high], w[low:high], u_out[low:high]
    pi, li = peak[low:high], limit[low:high]
    passed = False
    for i in range(high - low):
        d = ui[i] - uj[i] + ri[i]
        d = 0.0 if d < SMALLEST_OVERLAP else d
        g = ki[i] * (d * sqrt(d))
        x = vi[i] + (kick * wi[i]) * (f - g)
        vi[i] = x
        out[i] = ui[i] + drift * x
        f = g
        p = pi[i]
        pi[i] = d if d > p else p
        passed |= not (d <= li[i])
    return passed, f


@jit
def _drift(u, v, drift, low, high):
    ui, vi = u[low:high], v[low:high]
    for i in range(high - low):
        ui[i] += drift * vi[i]


@jit
def _sweep(
    tally, state, constants, scratch, drive, left_pieces, tick, ticks, left_edge, right_edge, shift, drifts, kicks, passed
):
    """Advance the grains from left_edge to right_edge - 1 by `ticks`, the range moving left by `shift` grains a stage."""
    scalars = constants[SCALARS]
    n, stages = int(scalars[GRAINS]), len(kicks)
    h, left_kind, right_kind, static = scalars[STEP], scalars[LEFT_KIND], scalars[RIGHT_KIND], scalars[STATIC_FORCE]
    k, r, w, limit = constants[STIFFNESS], constants[REST], constants[INVERSE_MASS], constants[LIMIT]
    v, peak, here, there = state[V], state[PEAK], state[U], scratch[_OTHER_U]
    left, right = scratch[LEFT_DRIVE], scratch[RIGHT_DRIVE]
    left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
    right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
    # Tallies live in registers: (sum, compensation).
    work_left, work_right = (tally[WORK_LEFT], tally[WORK_LEFT + 1]), (tally[WORK_RIGHT], tally[WORK_RIGHT + 1])
    impulse_left, impulse_right = (tally[IMPULSE_LEFT], tally[IMPULSE_LEFT + 1]), (tally[IMPULSE_RIGHT], tally[IMPULSE_RIGHT + 1])
    left_base, right_base = 0.0, 0.0
    bad, done, stage = False, 0, 0
    for t in range(tick, tick + ticks):
        left_piece = kernels.next_piece(drive, left_piece, left_pieces, t)
        right_piece = kernels.next_piece(drive, right_piece, drive.shape[0], t)
        low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
        has_first, has_last = low == 1, high == n + 1 and low <= n
        n_left = kernels.recentre(drive, left_piece, 0, t, left) if has_first else 1
        n_right = kernels.recentre(drive, right_piece, left_pieces, t, right) if right_edge > n else 1
        first_piston, last_piston = has_first and left_kind == PISTON, right_kind == PISTON
        if first_piston:
            left_base = here[1]
        if has_last:
            right_base = here[n]
        _drift(here, v, drifts[0] * h, low, max(low, high))
        if first_piston:
            here[1] = left_base + h * kernels.integral(left, n_left, drifts[0])
        if last_piston and has_last:
            here[n] = right_base + h * kernels.integral(right, n_right, drifts[0])
        stage += 1
        for s in range(stages):
            low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
            stage += 1
            if low >= high:
                here, there = there, here
                continue
            e, kick, drift = passed[s], kicks[s] * h, drifts[s + 1] * h
            f = kernels.hertz(here[low - 1] - here[low] + r[low - 1], k[low - 1])
            force, before = 0.0, v[1]
            if has_first:
                if left_kind == FREE:
                    force = static + kernels.value(left, n_left, e)
                    f = force
                impulse_left = kernels.added(impulse_left, kick * f)
                if s == 0:
                    d = here[0] - here[1] + r[0]
                    peak[0] = max(peak[0], d)
                    bad |= not (d <= limit[0])
            end = min(high, n)
            if s == 0:
                over, f = _kick_and_drift_watched(here, there, v, k, r, w, peak, limit, kick, drift, f, low, end)
                bad |= over
            else:
                f = _kick_and_drift(here, there, v, k, r, w, kick, drift, f, low, end)
            if high == n + 1:
                d = here[n] - here[n + 1] + r[n]
                g = kernels.hertz(d, k[n])
                pull, last = 0.0, v[n]
                if right_kind == FREE:
                    pull = kernels.value(right, n_right, e) - static
                v[n] = last + (kick * w[n]) * (f - (g - pull))
                there[n] = here[n] + drift * v[n]
                if s == 0:
                    peak[n] = max(peak[n], d)
                    bad |= not (d <= limit[n])
                if right_kind == PISTON:
                    impulse_right = kernels.added(impulse_right, -kick * f)
                    work_right = kernels.added(work_right, -kick * f * kernels.value(right, n_right, e))
                    there[n] = right_base + h * kernels.integral(right, n_right, e + drifts[s + 1])
                else:
                    impulse_right = kernels.added(impulse_right, kick * (pull - g))
                    work_right = kernels.added(work_right, kick * pull * (0.5 * (last + v[n])))
            if has_first:
                if left_kind == PISTON:
                    g = kernels.hertz(here[1] - here[2] + r[1], k[1])
                    impulse_left = kernels.added(impulse_left, kick * g)
                    work_left = kernels.added(work_left, kick * g * kernels.value(left, n_left, e))
                    there[1] = left_base + h * kernels.integral(left, n_left, e + drifts[s + 1])
                else:
                    work_left = kernels.added(work_left, kick * force * (0.5 * (before + v[1])))
            here, there = there, here
        # A prescribed grain's velocity is that at the end of the step.
        if first_piston:
            after = kernels.value(left, n_left, 1.0)
            work_left = kernels.added(work_left, 0.5 * scalars[LEFT_MASS] * (after - v[1]) * (after + v[1]))
            impulse_left = kernels.added(impulse_left, scalars[LEFT_MASS] * (after - v[1]))
            v[1] = after
        if last_piston and high == n + 1 and low < high:
            after = kernels.value(right, n_right, 1.0)
            work_right = kernels.added(work_right, 0.5 * scalars[RIGHT_MASS] * (after - v[n]) * (after + v[n]))
            impulse_right = kernels.added(impulse_right, scalars[RIGHT_MASS] * (after - v[n]))
            v[n] = after
        done += 1
        if bad and shift == 0:
            break
    tally[WORK_LEFT], tally[WORK_LEFT + 1] = work_left
    tally[WORK_RIGHT], tally[WORK_RIGHT + 1] = work_right
    tally[IMPULSE_LEFT], tally[IMPULSE_LEFT + 1] = impulse_left
    tally[IMPULSE_RIGHT], tally[IMPULSE_RIGHT + 1] = impulse_right
    return done, bad


@jit
def _advance(memory, constants, scratch, drive, left_pieces, tick, ticks, drifts, kicks, passed):
    width, n, stages = constants.shape[1], int(constants[SCALARS, GRAINS]), len(kicks)
    tally, state = kernels.parts(memory, STATE_ROWS, width)
    other = scratch[_OTHER_U]
    other[0], other[n + 1] = 0.0, 0.0
    done, bad = 0, False
    # A chain that fits the cache is one tile that stands still.
    tiled = n > TILED_ABOVE
    block = max(1, _BLOCK_STAGES // (stages + 1)) if tiled else ticks
    tile = _TILE_GRAINS if tiled else n
    while done < ticks and not bad:
        some, edge = min(block, ticks - done), 1
        last_edge = n + 1 + some * (stages + 1) if tiled else 2
        advanced = 0
        while edge < last_edge:
            advanced, over = _sweep(
                tally, state, constants, scratch, drive, left_pieces, tick + done, some, edge, edge + tile, int(tiled),
                drifts, kicks, passed,
            )  # fmt: skip
            bad |= over
            edge += tile
        if (advanced * stages) % 2:
            state[U][:] = other
        done += advanced
    return -done if bad or kernels.unsound(state, constants) else done


@jit
def advance_pefrl(memory, constants, scratch, drive, left_pieces, tick, ticks):
    """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
    return _advance(memory, constants, scratch, drive, left_pieces, tick, ticks, _PEFRL_DRIFTS, _PEFRL_KICKS, _PEFRL_PASSED)


@jit
def advance_leapfrog(memory, constants, scratch, drive, left_pieces, tick, ticks):
    """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
    return _advance(
        memory, constants, scratch, drive, left_pieces, tick, ticks, _LEAPFROG_DRIFTS, _LEAPFROG_KICKS, _LEAPFROG_PASSED
    )
