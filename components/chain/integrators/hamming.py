"""Hamming's predictor-corrector of order 4 with its modifier, the other scheme that Nesterenko (1983) used.

R. W. Hamming, J. ACM 6 (1959) 37: p = y_{n-3} + (4h/3)(2 f_n - f_{n-1} + 2 f_{n-2}); the modifier 112/121 and the mop-up 9/121; two
forces a step. Three Runge-Kutta steps start it, and start it again where an input jumps. Its memory is part of the state.
"""

from __future__ import annotations

from ...jit import jit
from .. import kernels
from ..kernels import GRAINS, HISTORY_DRIVE, HISTORY_LENGTH, SCALARS, STEP, U, V
from . import runge_kutta
from .runge_kutta import runge_kutta_step

# Rows behind U, V, PEAK: u and v one, two, three steps ago; a now, one and two steps ago; predictor minus corrector of u and v.
_U1, _V1, _U2, _V2, _U3, _V3, _A0, _A1, _A2, _GAP_U, _GAP_V = range(kernels.STATE_ROWS, kernels.STATE_ROWS + 11)
STATE_ROWS = kernels.STATE_ROWS + 11

# Rows of the scratch behind the Runge-Kutta ones: predicted and modified u and v, and a there.
_PU, _PV, _MU, _MV, _MA = range(runge_kutta.SCRATCH_ROWS, runge_kutta.SCRATCH_ROWS + 5)
SCRATCH_ROWS = runge_kutta.SCRATCH_ROWS + 5


@jit
def _shift_history(state):
    state[_U3][:], state[_V3][:] = state[_U2], state[_V2]
    state[_U2][:], state[_V2][:] = state[_U1], state[_V1]
    state[_U1][:], state[_V1][:] = state[U], state[V]


@jit
def _shift_accelerations(state):
    state[_A2][:] = state[_A1]
    state[_A1][:] = state[_A0]


@jit
def hamming_step(tally, state, constants, scratch, n_left, n_right, mark):
    """One step; Runge-Kutta while the history is shorter than three steps."""
    n = int(constants[SCALARS, GRAINS])
    h = constants[SCALARS, STEP]
    if tally[HISTORY_LENGTH] == 0.0 or tally[HISTORY_DRIVE] != mark:
        tally[HISTORY_LENGTH], tally[HISTORY_DRIVE] = 0.0, mark
        state[_GAP_U][:], state[_GAP_V][:] = 0.0, 0.0
        kernels.place_pistons(state[U], state[V], constants, scratch, n_left, n_right, state[U, 1], state[U, n], 0.0)
        kernels.derivative(state[U], state[V], constants, scratch, n_left, n_right, 0.0, state[_A0])
    if tally[HISTORY_LENGTH] < 3.0:
        _shift_history(state)
        runge_kutta_step(state, constants, scratch, n_left, n_right)
        tally[HISTORY_LENGTH] += 1.0
    else:
        _predict_and_correct(state, constants, scratch, n_left, n_right, n, h)
    _shift_accelerations(state)
    kernels.derivative(state[U], state[V], constants, scratch, n_left, n_right, 1.0, state[_A0])


@jit
def _predict_and_correct(state, constants, scratch, n_left, n_right, n, h):
    u, v, v1, v2 = state[U], state[V], state[_V1], state[_V2]
    a0, a1, a2 = state[_A0], state[_A1], state[_A2]
    pu, pv, mu, mv, ma = scratch[_PU], scratch[_PV], scratch[_MU], scratch[_MV], scratch[_MA]
    left_base, right_base = u[1], u[n]
    mu[:], mv[:] = u, v
    for i in range(1, n + 1):
        pu[i] = state[_U3, i] + 4.0 * h / 3.0 * (2.0 * v[i] - v1[i] + 2.0 * v2[i])
        mu[i] = pu[i] - 112.0 / 121.0 * state[_GAP_U, i]
    for i in range(1, n + 6):
        pv[i] = state[_V3, i] + 4.0 * h / 3.0 * (2.0 * a0[i] - a1[i] + 2.0 * a2[i])
        mv[i] = pv[i] - 112.0 / 121.0 * state[_GAP_V, i]
    kernels.place_pistons(mu, mv, constants, scratch, n_left, n_right, left_base, right_base, 1.0)
    kernels.derivative(mu, mv, constants, scratch, n_left, n_right, 1.0, ma)
    for i in range(1, n + 1):
        c = (9.0 * u[i] - state[_U2, i]) / 8.0 + 3.0 * h / 8.0 * (mv[i] + 2.0 * v[i] - v1[i])
        state[_GAP_U, i] = pu[i] - c
        mu[i] = c + 9.0 / 121.0 * (pu[i] - c)
    for i in range(1, n + 6):
        c = (9.0 * v[i] - v2[i]) / 8.0 + 3.0 * h / 8.0 * (ma[i] + 2.0 * a0[i] - a1[i])
        state[_GAP_V, i] = pv[i] - c
        mv[i] = c + 9.0 / 121.0 * (pv[i] - c)
    _shift_history(state)
    u[:], v[:] = mu, mv
    kernels.place_pistons(u, v, constants, scratch, n_left, n_right, left_base, right_base, 1.0)


@jit
def advance_hamming(memory, constants, scratch, drive, left_pieces, tick, ticks):
    """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
    tally, state = kernels.parts(memory, STATE_ROWS, constants.shape[1])
    n = int(constants[SCALARS, GRAINS])
    left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
    right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
    for t in range(tick, tick + ticks):
        left_piece, right_piece, n_left, n_right, mark = kernels.turn(drive, left_pieces, left_piece, right_piece, t, scratch)
        left_before, right_before = state[V, 1], state[V, n]
        hamming_step(tally, state, constants, scratch, n_left, n_right, mark)
        if kernels.finish(tally, state, constants, left_before, right_before):
            return -(t + 1 - tick)
    return -ticks if kernels.unsound(state, constants) else ticks
