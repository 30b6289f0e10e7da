"""The classical Runge-Kutta scheme of order 4, one of the two that Nesterenko (1983) used."""

from __future__ import annotations

from ...support.jit import jit
from .. import equations_of_motion as equations
from ..layout import BESIDE_GRAINS, FREE_ROW, GRAINS, SCALARS, STEP, U, V

HISTORY_ROWS, SCRATCH_ROWS = 0, 5


@jit
def runge_kutta_step(a, scratch, n_left, n_right):
    """One step of the rows U and V, the ends' work and impulse behind V; scratch is the first of five rows.

    They are a stage's u, v and dv/dt, and the weighted sums of v and dv/dt.
    """
    n, h = int(a[SCALARS, GRAINS]), a[SCALARS, STEP]
    us, vs, rate, sum_v, sum_rate = scratch, scratch + 1, scratch + 2, scratch + 3, scratch + 4
    left_base, right_base = a[U, 1], a[U, n]
    for i in range(n + BESIDE_GRAINS):
        a[us, i], a[vs, i] = a[U, i], a[V, i]
        a[rate, i], a[sum_v, i], a[sum_rate, i] = 0.0, 0.0, 0.0
    equations.place_pistons(a, us, vs, n_left, n_right, left_base, right_base, 0.0)
    for stage in range(4):
        e = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = (1.0 if stage == 0 or stage == 3 else 2.0) / 6.0
        equations.derivative(a, us, vs, n_left, n_right, e, rate)
        for i in range(1, n + BESIDE_GRAINS):
            a[sum_v, i] += weight * a[vs, i]
            a[sum_rate, i] += weight * a[rate, i]
        if stage < 3:
            part = 1.0 if stage == 2 else 0.5
            for i in range(1, n + 1):
                a[us, i] = a[U, i] + part * h * a[vs, i]
            for i in range(1, n + BESIDE_GRAINS):
                a[vs, i] = a[V, i] + part * h * a[rate, i]
            equations.place_pistons(a, us, vs, n_left, n_right, left_base, right_base, part)
    for i in range(1, n + 1):
        a[U, i] += h * a[sum_v, i]
    for i in range(1, n + BESIDE_GRAINS):
        a[V, i] += h * a[sum_rate, i]
    equations.place_pistons(a, U, V, n_left, n_right, left_base, right_base, 1.0)


@jit
def advance_rk4(a, drive, left_pieces, left, right, tick, ticks):
    """Advance by `ticks`, or until a limit is passed; see `equations_of_motion.outcome` for what it returns."""
    n = int(a[SCALARS, GRAINS])
    left_piece = equations.piece_at(drive, 0, left_pieces, tick)
    right_piece = equations.piece_at(drive, left_pieces, drive.shape[0], tick)
    for t in range(tick, tick + ticks):
        left_piece, right_piece, n_left, n_right, _ = equations.turn(
            a, drive, left_pieces, left_piece, right_piece, left, right, t
        )
        left_before, right_before = a[V, 1], a[V, n]
        runge_kutta_step(a, FREE_ROW, n_left, n_right)
        passed, unsound = equations.finish(a, left_before, right_before)
        if passed or unsound:
            return equations.outcome(t + 1 - tick, passed, unsound)
    return ticks
