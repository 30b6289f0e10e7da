"""Symplectic compositions of drifts (u += c h v) and kicks (v += b h F/m): PEFRL and leapfrog.

PEFRL: I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188, eq. (20): order 4, four forces a
step. Leapfrog (position Verlet): order 2, one force a step.

Work and impulse of the ends are advanced by the exact flow of each kick, so they have the order of the scheme.

A stage reads displacements from one row and writes them to another (a loop in place does not vectorise), velocities in
place. A range of grains can be advanced through many stages before its neighbours are, which keeps chains that do not
fit the cache in it: the range moves one grain to the left with every stage, so whatever a stage reads has been written
by the stage before it. Tiled or not, each grain's arithmetic is the same, and so are the bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...support.jit import internal, internal_inlined, jit
from .. import equations_of_motion as equations
from ..laws import placeholders as law
from ..laws.placeholders import DISSIPATES, LONG_FORMULA, REMEMBERS
from ..layout import (
    FREE,
    FREE_ROW,
    GRAINS,
    GRAVITY,
    IMPULSE_LEFT,
    IMPULSE_PER_SPEED,
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
    RIGHT_BASE,
    RIGHT_DRIVE,
    RIGHT_KIND,
    RIGHT_MASS,
    RIGHT_STATIC,
    SCALARS,
    SPEED_LIMIT,
    STEP,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)
from .dissipative_step import dissipate_and_drift


class Composition(NamedTuple):
    """Drifts and kicks in turn, as parts of the step; and the part of it that has passed when each kick falls.

    Of a damped one the middle kick is the flow of the dissipative forces.
    """

    drifts: tuple[float, ...]
    kicks: tuple[float, ...]
    passed: tuple[float, ...]


_XI, _LAMBDA, _CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
_MIDDLE = 1.0 - 2.0 * (_CHI + _XI)
_OUTER_KICK = (1.0 - 2.0 * _LAMBDA) / 2.0
PEFRL = Composition(
    (_XI, _CHI, _MIDDLE, _CHI, _XI),
    (_OUTER_KICK, _LAMBDA, _LAMBDA, _OUTER_KICK),
    (_XI, _XI + _CHI, 1.0 - (_XI + _CHI), 1.0 - _XI),
)
LEAPFROG = Composition((0.5, 0.5), (1.0,), (0.5,))
# With dissipation its flow over the whole step takes the middle: the composition stays symmetric, and so of second order.
DAMPED_PEFRL = Composition(
    (_XI, _CHI, 0.5 * _MIDDLE, 0.5 * _MIDDLE, _CHI, _XI),
    (_OUTER_KICK, _LAMBDA, 0.0, _LAMBDA, _OUTER_KICK),
    (_XI, _XI + _CHI, 0.5, 1.0 - (_XI + _CHI), 1.0 - _XI),
)
DAMPED_LEAPFROG = Composition((0.5, 0.0, 0.0, 0.5), (0.5, 0.0, 0.5), (0.5, 0.5, 0.5))

# Chains longer than this are advanced tile by tile: the table of a shorter one fits a second-level cache.
TILED_ABOVE = 16_384
# A tile has to be wider than a block has stages, or it would move past the chain's left end.
_TILE_GRAINS = 4096
_BLOCK_STAGES = 128

# From so many grains on the call of a function costs a stage nothing.
_LONG = 256

# The second row of displacements is the only scratch.
_OTHER_U = FREE_ROW
HISTORY_ROWS, SCRATCH_ROWS = 0, 1

_ONE = np.uint64(1)


@internal_inlined
def kick_and_drift(falling, watched, a, here, there, kick, drift, f, low, high):
    """Grains low..high-1: v += kick ((f_left - f_right) / m + gravity), u_there = u_here + drift v.

    f enters as the force left of `low`, and leaves as that left of `high`. Where `watched`, once a step, peaks are kept,
    and whether an overlap is above its limit is returned.
    """
    fall = kick * a[SCALARS, GRAVITY]
    passed = False
    if LONG_FORMULA:
        # Long formulas become vectors only where no force is carried from contact to contact.
        for i in range(np.uint64(low), np.uint64(high)):
            d = a[here, i] - a[here, i + _ONE] + a[REST_OVERLAP, i]
            a[IMPULSE_PER_SPEED, i] = law.force(a, i, equations.pressed(d))
    for i in range(np.uint64(low), np.uint64(high)):
        d = equations.pressed(a[here, i] - a[here, i + _ONE] + a[REST_OVERLAP, i])
        g = a[IMPULSE_PER_SPEED, i] if LONG_FORMULA else law.force(a, i, d)
        v = a[V, i] + (kick * a[INVERSE_MASS, i]) * (f - g)
        if falling:
            v += fall
        a[V, i] = v
        a[there, i] = a[here, i] + drift * v
        f = g
        if watched:
            p = a[PEAK, i]
            a[PEAK, i] = d if d > p else p
            passed |= not (d <= a[LIMIT, i])
    return f, passed


@internal
def stage_loop(falling, watched, a, here, there, kick, drift, f, low, high):
    """Return `kick_and_drift`. A function of its own: within `_sweep` its loops lack registers, and load constants anew."""
    if falling:
        return kick_and_drift(True, watched, a, here, there, kick, drift, f, low, high)
    if watched:
        return kick_and_drift(False, True, a, here, there, kick, drift, f, low, high)
    return kick_and_drift(False, False, a, here, there, kick, drift, f, low, high)


@internal
def _too_fast(a, fastest, low, high):
    """Return whether a velocity is above its limit or not a number."""
    found = False
    for i in range(np.uint64(low), np.uint64(high)):
        found |= not (abs(a[V, i]) <= fastest)
    return found


@internal_inlined
def _drift(a, here, drift, low, high):
    for i in range(np.uint64(low), np.uint64(high)):
        a[here, i] += drift * a[V, i]


@internal_inlined
def _watch(a, here, j):
    """Keep the peak of one contact; whether it is above its limit."""
    d = a[here, j] - a[here, j + 1] + a[REST_OVERLAP, j]
    a[PEAK, j] = max(a[PEAK, j], d)
    return not (d <= a[LIMIT, j])


@internal
def _sweep(a, drive, left_pieces, left, right, tick, ticks, left_edge, right_edge, shift, drifts, kicks, passed):
    """Advance the grains from left_edge to right_edge - 1 by `ticks`, the range moving left by `shift` grains a stage."""
    n, stages = int(a[SCALARS, GRAINS]), len(kicks)
    h, gravity = a[SCALARS, STEP], a[SCALARS, GRAVITY]
    left_piston, left_free = a[SCALARS, LEFT_KIND] == PISTON, a[SCALARS, LEFT_KIND] == FREE
    right_piston, right_free = a[SCALARS, RIGHT_KIND] == PISTON, a[SCALARS, RIGHT_KIND] == FREE
    here, there = U, _OTHER_U
    left_piece = equations.piece_at(drive, 0, left_pieces, tick)
    right_piece = equations.piece_at(drive, left_pieces, drive.shape[0], tick)
    work_left, work_right = equations.tally(a, WORK_LEFT), equations.tally(a, WORK_RIGHT)
    impulse_left, impulse_right = equations.tally(a, IMPULSE_LEFT), equations.tally(a, IMPULSE_RIGHT)
    # The tile before may have handed the last grain over in mid-tick.
    left_base, right_base = 0.0, a[SCALARS, RIGHT_BASE]
    fastest = a[SCALARS, SPEED_LIMIT]
    bad, unsound, done, stage = False, False, 0, 0
    for t in range(tick, tick + ticks):
        left_piece = equations.next_piece(drive, left_piece, left_pieces, t)
        right_piece = equations.next_piece(drive, right_piece, drive.shape[0], t)
        low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
        has_first, has_last = low == 1, right_edge > n
        n_left = equations.recentre(a, LEFT_DRIVE, drive, left_piece, 0, left, t) if has_first else 1
        n_right = equations.recentre(a, RIGHT_DRIVE, drive, right_piece, left_pieces, right, t) if has_last else 1
        if has_first:
            left_base = a[here, 1]
        if high == n + 1 and low <= n:
            right_base = a[here, n]
            a[SCALARS, RIGHT_BASE] = right_base
        _drift(a, here, drifts[0] * h, low, max(low, high))
        if has_first and left_piston:
            a[here, 1] = left_base + h * equations.integral(a, LEFT_DRIVE, n_left, drifts[0])
        if high == n + 1 and low <= n and right_piston:
            a[here, n] = right_base + h * equations.integral(a, RIGHT_DRIVE, n_right, drifts[0])
        stage += 1
        for s in range(stages):
            if DISSIPATES and s == stages // 2:
                # A damped chain is one tile. Prescribed grains move at the speed of the middle meanwhile.
                first, last = a[V, 1], a[V, n]
                if left_piston:
                    a[V, 1] = equations.value(a, LEFT_DRIVE, n_left, 0.5)
                if right_piston:
                    a[V, n] = equations.value(a, RIGHT_DRIVE, n_right, 0.5)
                given = dissipate_and_drift(a, here, h, drifts[s + 1] * h)
                impulse_left, impulse_right = equations.add(impulse_left, given[0]), equations.add(impulse_right, given[1])
                work_left, work_right = equations.add(work_left, given[2]), equations.add(work_right, given[3])
                e = 0.5 + drifts[s + 1]
                if left_piston:
                    a[V, 1] = first
                    a[here, 1] = left_base + h * equations.integral(a, LEFT_DRIVE, n_left, e)
                if right_piston:
                    a[V, n] = last
                    a[here, n] = right_base + h * equations.integral(a, RIGHT_DRIVE, n_right, e)
                continue
            low, high = max(left_edge - shift * stage, 1), min(right_edge - shift * stage, n + 1)
            stage += 1
            if low < high:
                e, kick, drift = passed[s], kicks[s] * h, drifts[s + 1] * h
                f, push, first = equations.contact(a, here, low - 1), 0.0, a[V, 1]
                if has_first:
                    if left_free:
                        push = a[SCALARS, LEFT_STATIC] + equations.value(a, LEFT_DRIVE, n_left, e)
                        f = push
                    impulse_left = equations.add(impulse_left, kick * f)
                    bad |= s == 0 and _watch(a, here, 0)
                if gravity != 0.0 or high - low >= _LONG:
                    f, over = stage_loop(gravity != 0.0, s == 0, a, here, there, kick, drift, f, low, min(high, n))
                    bad |= over
                elif s == 0:
                    f, over = kick_and_drift(False, True, a, here, there, kick, drift, f, low, min(high, n))
                    bad |= over
                else:
                    f, _ = kick_and_drift(False, False, a, here, there, kick, drift, f, low, min(high, n))
                if high == n + 1:
                    g, pull, last = equations.contact(a, here, n), 0.0, a[V, n]
                    if right_free:
                        pull = equations.value(a, RIGHT_DRIVE, n_right, e) - a[SCALARS, RIGHT_STATIC]
                    a[V, n] = (last + (kick * a[INVERSE_MASS, n]) * (f - (g - pull))) + (
                        0.0 if right_piston else kick * gravity
                    )
                    a[there, n] = a[here, n] + drift * a[V, n]
                    bad |= s == 0 and _watch(a, here, n)
                    if right_piston:
                        impulse_right = equations.add(impulse_right, -kick * f)
                        work_right = equations.add(work_right, -kick * f * equations.value(a, RIGHT_DRIVE, n_right, e))
                        a[there, n] = right_base + h * equations.integral(a, RIGHT_DRIVE, n_right, e + drifts[s + 1])
                    else:
                        impulse_right = equations.add(impulse_right, kick * (pull - g))
                        work_right = equations.add(work_right, kick * pull * (0.5 * (last + a[V, n])))
                if has_first:
                    if left_piston:
                        a[V, 1] = first  # gravity does not move it
                        g = equations.contact(a, here, 1)
                        impulse_left = equations.add(impulse_left, kick * g)
                        work_left = equations.add(work_left, kick * g * equations.value(a, LEFT_DRIVE, n_left, e))
                        a[there, 1] = left_base + h * equations.integral(a, LEFT_DRIVE, n_left, e + drifts[s + 1])
                    else:
                        work_left = equations.add(work_left, kick * push * (0.5 * (first + a[V, 1])))
            here, there = there, here
        # A prescribed grain's velocity is that at the end of the step; its change is work and impulse of the piston.
        if has_first and left_piston:
            first, last = a[V, 1], equations.value(a, LEFT_DRIVE, n_left, 1.0)
            work_left = equations.add(work_left, 0.5 * a[SCALARS, LEFT_MASS] * (last - first) * (last + first))
            impulse_left = equations.add(impulse_left, a[SCALARS, LEFT_MASS] * (last - first))
            a[V, 1] = last
        if high == n + 1 and low <= n and right_piston:
            first, last = a[V, n], equations.value(a, RIGHT_DRIVE, n_right, 1.0)
            work_right = equations.add(work_right, 0.5 * a[SCALARS, RIGHT_MASS] * (last - first) * (last + first))
            impulse_right = equations.add(impulse_right, a[SCALARS, RIGHT_MASS] * (last - first))
            a[V, n] = last
        if REMEMBERS:
            equations.remember(a, here)
        # Velocities count as they are at the end of every step, however many steps a call makes.
        unsound |= _too_fast(a, fastest, low, max(low, high))
        done += 1
        if (bad or unsound) and shift == 0:
            break
    equations.keep(a, WORK_LEFT, work_left)
    equations.keep(a, WORK_RIGHT, work_right)
    equations.keep(a, IMPULSE_LEFT, impulse_left)
    equations.keep(a, IMPULSE_RIGHT, impulse_right)
    return done, bad, unsound


@internal
def _advance(a, drive, left_pieces, left, right, tick, ticks, drifts, kicks, passed):
    n, stages = int(a[SCALARS, GRAINS]), len(kicks)
    swaps = stages - 1 if DISSIPATES else stages
    a[_OTHER_U, 0], a[_OTHER_U, n + 1] = 0.0, 0.0
    done, bad, unsound = 0, False, False
    # A chain that fits the cache is one tile that stands still; so is one whose contacts tell of more than their overlaps.
    tiled = n > TILED_ABOVE and not DISSIPATES and not REMEMBERS
    block = max(1, _BLOCK_STAGES // (stages + 1)) if tiled else ticks
    tile = _TILE_GRAINS if tiled else n
    while done < ticks and not (bad or unsound):
        some, edge, advanced = min(block, ticks - done), 1, 0
        last_edge = n + 1 + some * (stages + 1) if tiled else 2
        while edge < last_edge:
            advanced, over, fast = _sweep(
                a, drive, left_pieces, left, right, tick + done, some, edge, edge + tile, int(tiled), drifts, kicks, passed
            )
            bad |= over
            unsound |= fast
            edge += tile
        if (advanced * swaps) % 2:
            for i in range(np.uint64(n + 2)):
                a[U, i] = a[_OTHER_U, i]
        done += advanced
    return equations.outcome(done, bad, unsound)


@jit
def advance_pefrl(a, drive, left_pieces, left, right, tick, ticks):
    """Advance by `ticks`, or until a limit is passed; see `equations_of_motion.outcome` for what it returns."""
    if DISSIPATES:
        parts = DAMPED_PEFRL
    else:
        parts = PEFRL
    return _advance(a, drive, left_pieces, left, right, tick, ticks, parts.drifts, parts.kicks, parts.passed)


@jit
def advance_leapfrog(a, drive, left_pieces, left, right, tick, ticks):
    """Advance by `ticks`, or until a limit is passed; see `equations_of_motion.outcome` for what it returns."""
    if DISSIPATES:
        parts = DAMPED_LEAPFROG
    else:
        parts = LEAPFROG
    return _advance(a, drive, left_pieces, left, right, tick, ticks, parts.drifts, parts.kicks, parts.passed)
