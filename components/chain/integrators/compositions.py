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
    TALLY,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)

_XI, _LAMBDA, _CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
_SCHEMES = {
    "pefrl": (
        (_XI, _CHI, 1.0 - 2.0 * (_CHI + _XI), _CHI, _XI),
        ((1.0 - 2.0 * _LAMBDA) / 2.0, _LAMBDA, _LAMBDA, (1.0 - 2.0 * _LAMBDA) / 2.0),
    ),
    "leapfrog": ((0.5, 0.5), (1.0,)),
}

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


def _composition(drifts, kicks):
    """The two kernels of a scheme, its coefficients compiled in."""
    stages = len(kicks)
    # The part of the step that has passed when each kick falls.
    passed_at = tuple(sum(drifts[: stage + 1]) for stage in range(stages))
    first_drift = drifts[0]

    @jit
    def sweep(tally, state, constants, scratch, drive, left_pieces, tick, ticks, left_edge, right_edge, shift):
        """Advance the grains from left_edge to right_edge - 1 by `ticks`, the range moving left by `shift` a stage."""
        scalars = constants[SCALARS]
        n = int(scalars[8])
        h, left_kind, right_kind, static = scalars[STEP], scalars[LEFT_KIND], scalars[RIGHT_KIND], scalars[STATIC_FORCE]
        k, r, w, limit = constants[STIFFNESS], constants[REST], constants[INVERSE_MASS], constants[LIMIT]
        v, peak = state[V], state[PEAK]
        here, there = state[U], scratch[_OTHER_U]
        left, right = scratch[LEFT_DRIVE], scratch[RIGHT_DRIVE]
        left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
        right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
        bad = False
        stage = 0
        for t in range(tick, tick + ticks):
            while left_piece + 1 < left_pieces and drive[left_piece + 1, 0] <= t:
                left_piece += 1
            while right_piece + 1 < drive.shape[0] and drive[right_piece + 1, 0] <= t:
                right_piece += 1
            low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
            n_left = kernels.recentre(drive, left_piece, 0, t, left) if low == 1 else 1
            n_right = kernels.recentre(drive, right_piece, left_pieces, t, right) if right_edge > n else 1
            if low == 1 and high > 1:
                left_base = here[1]
            if high == n + 1 and low <= n:
                right_base = here[n]
            _drift(here, v, first_drift * h, low, max(low, high))
            if left_kind == PISTON and low == 1 and high > 1:
                here[1] = left_base + h * kernels.integral(left, n_left, first_drift)
            if right_kind == PISTON and high == n + 1 and low <= n:
                here[n] = right_base + h * kernels.integral(right, n_right, first_drift)
            stage += 1
            for s in range(stages):
                low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
                stage += 1
                if low < high:
                    e = passed_at[s]
                    kick, drift = kicks[s] * h, drifts[s + 1] * h
                    f = kernels.hertz(here[low - 1] - here[low] + r[low - 1], k[low - 1])
                    force, before = 0.0, v[1]
                    if low == 1:
                        if left_kind == FREE:
                            force = static + kernels.value(left, n_left, e)
                            f = f + force
                        kernels.accumulate(tally, IMPULSE_LEFT, kick * f)
                        if s == 0:
                            d = max(here[0] - here[1] + r[0], 0.0)
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
                        net = f - (g - pull)
                        v[n] = last + (kick * w[n]) * net
                        there[n] = here[n] + drift * v[n]
                        if s == 0 and k[n] > 0.0:
                            peak[n] = max(peak[n], d)
                            bad |= not (d <= limit[n])
                        if right_kind == PISTON:
                            speed = kernels.value(right, n_right, e)
                            kernels.accumulate(tally, IMPULSE_RIGHT, -kick * f)
                            kernels.accumulate(tally, WORK_RIGHT, -kick * f * speed)
                            there[n] = right_base + h * kernels.integral(right, n_right, e + drifts[s + 1])
                        else:
                            kernels.accumulate(tally, IMPULSE_RIGHT, kick * (pull - g))
                            if right_kind == FREE:
                                kernels.accumulate(tally, WORK_RIGHT, kick * pull * (0.5 * (last + v[n])))
                    if low == 1:
                        if left_kind == FREE:
                            kernels.accumulate(tally, WORK_LEFT, kick * force * (0.5 * (before + v[1])))
                        elif left_kind == PISTON:
                            g = kernels.hertz(here[1] - here[2] + r[1], k[1])
                            kernels.accumulate(tally, IMPULSE_LEFT, kick * g)
                            kernels.accumulate(tally, WORK_LEFT, kick * g * kernels.value(left, n_left, e))
                            there[1] = left_base + h * kernels.integral(left, n_left, e + drifts[s + 1])
                here, there = there, here
            # A prescribed grain's velocity is that at the end of the step.
            if left_kind == PISTON and low == 1 and low < high:
                after = kernels.value(left, n_left, 1.0)
                kernels.tally_piston(tally, scalars[LEFT_MASS], v[1], after, WORK_LEFT, IMPULSE_LEFT)
                v[1] = after
            if right_kind == PISTON and high == n + 1 and low < high:
                after = kernels.value(right, n_right, 1.0)
                kernels.tally_piston(tally, scalars[RIGHT_MASS], v[n], after, WORK_RIGHT, IMPULSE_RIGHT)
                v[n] = after
            if bad and shift == 0:
                return t + 1 - tick, True
        return ticks, bad

    @jit
    def advance(memory, constants, scratch, drive, left_pieces, tick, ticks):
        """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
        width = constants.shape[1]
        tally = memory[:TALLY]
        state = memory[TALLY : TALLY + STATE_ROWS * width].reshape((STATE_ROWS, width))
        n = int(constants[SCALARS, 8])
        other = scratch[_OTHER_U]
        other[0], other[n + 1] = 0.0, 0.0
        done, bad = 0, False
        if n <= TILED_ABOVE:
            done, bad = sweep(tally, state, constants, scratch, drive, left_pieces, tick, ticks, 1, n + 1, 0)
            if (done * stages) % 2:
                state[U][:] = other
        else:
            block = max(1, _BLOCK_STAGES // (stages + 1))
            while done < ticks and not bad:
                some = min(block, ticks - done)
                edge = 1
                while edge < n + 1 + some * (stages + 1):
                    _, over = sweep(
                        tally, state, constants, scratch, drive, left_pieces, tick + done, some, edge, edge + _TILE_GRAINS, 1
                    )
                    bad |= over
                    edge += _TILE_GRAINS
                if (some * stages) % 2:
                    state[U][:] = other
                done += some
        if bad or kernels.unsound(state, constants):
            return -done
        return done

    return advance


advance_pefrl = _composition(*_SCHEMES["pefrl"])
advance_leapfrog = _composition(*_SCHEMES["leapfrog"])
