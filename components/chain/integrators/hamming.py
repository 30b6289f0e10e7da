"""Hamming's predictor-corrector with its modifier, the other scheme that Nesterenko (1983) used.

R. W. Hamming, J. ACM 6 (1959) 37: p = y_{n-3} + (4h/3)(2 f_n - f_{n-1} + 2 f_{n-2}); the modifier 112/121 and the
mop-up 9/121; two forces a step. The formulas are of order 4; the mop-up takes their leading error away, and order 5 is
what is measured. Three Runge-Kutta steps start it, and start it again where an input jumps. Its memory is part of the
state.
"""

from __future__ import annotations

from ...support.jit import jit
from .. import equations_of_motion as equations
from ..layout import BESIDE_GRAINS, FREE_ROW, GRAINS, HISTORY_DRIVE, HISTORY_LENGTH, SCALARS, STEP, TALLY, U, V
from . import runge_kutta
from .runge_kutta import runge_kutta_step

# History: u and v one, two, three steps ago; dv/dt now, one and two steps ago; predictor minus corrector of u and v.
_U1, _V1, _U2, _V2, _U3, _V3, _A0, _A1, _A2, _GAP_U, _GAP_V = range(FREE_ROW, FREE_ROW + 11)
HISTORY_ROWS = 11

# Scratch: the Runge-Kutta rows, then predicted and modified u and v, and dv/dt there.
_RUNGE_KUTTA = _GAP_V + 1
_PU, _PV, _MU, _MV, _MA = range(_RUNGE_KUTTA + runge_kutta.SCRATCH_ROWS, _RUNGE_KUTTA + runge_kutta.SCRATCH_ROWS + 5)
SCRATCH_ROWS = runge_kutta.SCRATCH_ROWS + 5


@jit
def _shift_history(a, n):
    for i in range(n + BESIDE_GRAINS):
        a[_U3, i], a[_V3, i] = a[_U2, i], a[_V2, i]
        a[_U2, i], a[_V2, i] = a[_U1, i], a[_V1, i]
        a[_U1, i], a[_V1, i] = a[U, i], a[V, i]


@jit
def _shift_accelerations(a, n):
    for i in range(n + BESIDE_GRAINS):
        a[_A2, i] = a[_A1, i]
        a[_A1, i] = a[_A0, i]


@jit
def _start(a, n, n_left, n_right, mark):
    """Forget what was before a drive changed."""
    a[TALLY, HISTORY_LENGTH], a[TALLY, HISTORY_DRIVE], a[TALLY, HISTORY_DRIVE + 1] = 0.0, mark[0], mark[1]
    for i in range(n + BESIDE_GRAINS):
        a[_GAP_U, i], a[_GAP_V, i] = 0.0, 0.0
    equations.place_pistons(a, U, V, n_left, n_right, a[U, 1], a[U, n], 0.0)
    equations.derivative(a, U, V, n_left, n_right, 0.0, _A0)


@jit
def _predict_and_correct(a, n, n_left, n_right):
    h = a[SCALARS, STEP]
    left_base, right_base = a[U, 1], a[U, n]
    for i in range(1, n + 1):
        a[_PU, i] = a[_U3, i] + 4.0 * h / 3.0 * (2.0 * a[V, i] - a[_V1, i] + 2.0 * a[_V2, i])
        a[_MU, i] = a[_PU, i] - 112.0 / 121.0 * a[_GAP_U, i]
    for i in range(1, n + BESIDE_GRAINS):
        a[_PV, i] = a[_V3, i] + 4.0 * h / 3.0 * (2.0 * a[_A0, i] - a[_A1, i] + 2.0 * a[_A2, i])
        a[_MV, i] = a[_PV, i] - 112.0 / 121.0 * a[_GAP_V, i]
    equations.place_pistons(a, _MU, _MV, n_left, n_right, left_base, right_base, 1.0)
    equations.derivative(a, _MU, _MV, n_left, n_right, 1.0, _MA)
    for i in range(1, n + 1):
        c = (9.0 * a[U, i] - a[_U2, i]) / 8.0 + 3.0 * h / 8.0 * (a[_MV, i] + 2.0 * a[V, i] - a[_V1, i])
        a[_GAP_U, i] = a[_PU, i] - c
        a[_MU, i] = c + 9.0 / 121.0 * (a[_PU, i] - c)
    for i in range(1, n + BESIDE_GRAINS):
        c = (9.0 * a[V, i] - a[_V2, i]) / 8.0 + 3.0 * h / 8.0 * (a[_MA, i] + 2.0 * a[_A0, i] - a[_A1, i])
        a[_GAP_V, i] = a[_PV, i] - c
        a[_MV, i] = c + 9.0 / 121.0 * (a[_PV, i] - c)
    _shift_history(a, n)
    for i in range(1, n + 1):
        a[U, i] = a[_MU, i]
    for i in range(1, n + BESIDE_GRAINS):
        a[V, i] = a[_MV, i]
    equations.place_pistons(a, U, V, n_left, n_right, left_base, right_base, 1.0)


@jit
def advance_hamming(a, drive, left_pieces, left, right, tick, ticks):
    """Advance by `ticks`, or until a limit is passed; see `equations_of_motion.outcome` for what it returns."""
    n = int(a[SCALARS, GRAINS])
    left_piece = equations.piece_at(drive, 0, left_pieces, tick)
    right_piece = equations.piece_at(drive, left_pieces, drive.shape[0], tick)
    for t in range(tick, tick + ticks):
        left_piece, right_piece, n_left, n_right, mark = equations.turn(
            a, drive, left_pieces, left_piece, right_piece, left, right, t
        )
        left_before, right_before = a[V, 1], a[V, n]
        if t == 0 or a[TALLY, HISTORY_DRIVE] != mark[0] or a[TALLY, HISTORY_DRIVE + 1] != mark[1]:
            _start(a, n, n_left, n_right, mark)
        if a[TALLY, HISTORY_LENGTH] < 3.0:
            _shift_history(a, n)
            runge_kutta_step(a, _RUNGE_KUTTA, n_left, n_right)
            a[TALLY, HISTORY_LENGTH] += 1.0
        else:
            _predict_and_correct(a, n, n_left, n_right)
        _shift_accelerations(a, n)
        equations.derivative(a, U, V, n_left, n_right, 1.0, _A0)
        passed, unsound = equations.finish(a, left_before, right_before)
        if passed or unsound:
            return equations.outcome(t + 1 - tick, passed, unsound)
    return ticks
