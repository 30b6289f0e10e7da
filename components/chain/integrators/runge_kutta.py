"""The classical Runge-Kutta scheme of order 4, one of the two that Nesterenko (1983) used."""

from __future__ import annotations

from ...jit import jit
from .. import kernels
from ..kernels import GRAINS, PISTON, SCALARS, STEP, U, V

# Rows of the scratch behind the drive's: a stage's u, v and a, and the weighted sums of v and a.
_U, _V, _A, _SUM_V, _SUM_A = 2, 3, 4, 5, 6
SCRATCH_ROWS = 7
STATE_ROWS = kernels.STATE_ROWS


@jit
def runge_kutta_step(state, constants, scratch, n_left, n_right):
    """One step: the state's rows U and V, the ends' work and impulse behind V."""
    n = int(constants[SCALARS, GRAINS])
    h = constants[SCALARS, STEP]
    u, v = state[U], state[V]
    us, vs, a, sum_v, sum_a = scratch[_U], scratch[_V], scratch[_A], scratch[_SUM_V], scratch[_SUM_A]
    left_base, right_base = u[1], u[n]
    sum_v[:], sum_a[:], a[:] = 0.0, 0.0, 0.0
    us[:], vs[:] = u, v
    if constants[SCALARS, kernels.LEFT_KIND] == PISTON or constants[SCALARS, kernels.RIGHT_KIND] == PISTON:
        kernels.place_pistons(us, vs, constants, scratch, n_left, n_right, left_base, right_base, 0.0)
    for stage in range(4):
        e = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = (1.0 if stage == 0 or stage == 3 else 2.0) / 6.0
        kernels.derivative(us, vs, constants, scratch, n_left, n_right, e, a)
        for i in range(1, n + 6):
            sum_v[i] += weight * vs[i]
            sum_a[i] += weight * a[i]
        if stage < 3:
            part = 1.0 if stage == 2 else 0.5
            for i in range(1, n + 1):
                us[i] = u[i] + part * h * vs[i]
            for i in range(1, n + 6):
                vs[i] = v[i] + part * h * a[i]
            kernels.place_pistons(us, vs, constants, scratch, n_left, n_right, left_base, right_base, part)
    for i in range(1, n + 1):
        u[i] += h * sum_v[i]
    for i in range(1, n + 6):
        v[i] += h * sum_a[i]
    kernels.place_pistons(u, v, constants, scratch, n_left, n_right, left_base, right_base, 1.0)


@jit
def advance_rk4(memory, constants, scratch, drive, left_pieces, tick, ticks):
    """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
    tally, state = kernels.parts(memory, STATE_ROWS, constants.shape[1])
    n = int(constants[SCALARS, GRAINS])
    left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
    right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
    for t in range(tick, tick + ticks):
        left_piece, right_piece, n_left, n_right, _ = kernels.turn(drive, left_pieces, left_piece, right_piece, t, scratch)
        left_before, right_before = state[V, 1], state[V, n]
        runge_kutta_step(state, constants, scratch, n_left, n_right)
        if kernels.finish(tally, state, constants, left_before, right_before):
            return -(t + 1 - tick)
    return -ticks if kernels.unsound(state, constants) else ticks
