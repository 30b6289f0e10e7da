"""DOP853, the reference: Dormand and Prince's explicit Runge-Kutta pair of order 8 with error control of orders 5 and 3.

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (Springer 1993), section II.10: the tableau and the
error estimate. Every tick begins anew with the whole tick as the first trial, so that the partition of steps leaves no trace; a step is cut
to end where an open contact would close. Square roots take the place of the usual eighth root's pow.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ...jit import jit
from .. import kernels
from ..kernels import GRAINS, REST, SCALARS, STEP, STIFFNESS, TOLERANCE, U, V

# Rows of the lower triangle of A, one after the other: row i begins at i (i - 1) / 2.
_A = np.array(
    [
        0.05260015195876773, 0.0197250569845379, 0.0591751709536137, 0.02958758547680685, 0.0, 0.08876275643042054,
        0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792, 0.037037037037037035, 0.0, 0.0,
        0.17082860872947386, 0.12546768756682242, 0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596,
        -0.017578125, 0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
        0.008273789163814023, 0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
        20.154067550477894, -43.48988418106996, 0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843,
        21.230051448181193, 15.279233632882423, -33.28821096898486, -0.020331201708508627, -0.9371424300859873, 0.0, 0.0,
        5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505,
        2.4936055526796523, -3.0467644718982196, 2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625,
        -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303,
        0.6433927460157636,
    ]
)
_B = np.array(
    [
        0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
        0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259,
    ]
)
_C = np.array(
    [
        0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25,
        0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0,
    ]
)
_E3 = np.array(
    [
        -0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
        -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082,
    ]
)
_E5 = np.array(
    [
        0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864,
        -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294,
    ]
)

_STAGES = 12
_SAFETY, _SMALLEST_FACTOR, _LARGEST_FACTOR = 0.9, 0.2, 5.0
_SMALLEST_PART = 1e-9

# Rows of the scratch behind the drive's: the twelve stages' v, then their a, then a stage's u and v.
_SV, _SA = 2, 2 + _STAGES
_SU, _SW = 2 + 2 * _STAGES, 3 + 2 * _STAGES
SCRATCH_ROWS = 4 + 2 * _STAGES
STATE_ROWS = kernels.STATE_ROWS


@jit
def _time_to_close(u, v, constants, n):
    """Steps until the first open contact closes at the present speeds; infinite if none does."""
    soonest = np.inf
    for j in range(n + 1):
        gap = -(u[j] - u[j + 1] + constants[REST, j])
        speed = v[j] - v[j + 1]
        if gap > 0.0 and speed > 0.0 and constants[STIFFNESS, j] > 0.0:
            soonest = min(soonest, gap / speed)
    return soonest / constants[SCALARS, STEP]


@jit
def _stages(u, v, constants, scratch, n_left, n_right, left_base, right_base, e, part, n):
    """The twelve derivatives of a trial from e to e + part."""
    h = constants[SCALARS, STEP] * part
    us, vs = scratch[_SU], scratch[_SW]
    for s in range(_STAGES):
        row = s * (s - 1) // 2
        us[:], vs[:] = u, v
        for q in range(s):
            weight = h * _A[row + q]
            if weight != 0.0:
                qv, qa = scratch[_SV + q], scratch[_SA + q]
                for i in range(1, n + 1):
                    us[i] += weight * qv[i]
                for i in range(1, n + 6):
                    vs[i] += weight * qa[i]
        at = e + _C[s] * part
        kernels.place_pistons(us, vs, constants, scratch, n_left, n_right, left_base, right_base, at)
        scratch[_SV + s][:] = vs
        kernels.derivative(us, vs, constants, scratch, n_left, n_right, at, scratch[_SA + s])


@jit
def _error(u, v, scratch, h, n, tolerance):
    """Hairer's combination of the two estimates, in the largest component, relative to the tolerance."""
    fastest = 0.0
    for i in range(1, n + 1):
        fastest = max(fastest, abs(v[i]))
    if fastest == 0.0:
        for i in range(1, n + 1):
            fastest = max(fastest, abs(scratch[_SA, i]) * h)
    if fastest == 0.0:
        return 0.0
    worst5, worst3 = 0.0, 0.0
    for i in range(1, n + 1):
        v5, v3, u5, u3 = 0.0, 0.0, 0.0, 0.0
        for s in range(_STAGES):
            v5 += _E5[s] * scratch[_SA + s, i]
            v3 += _E3[s] * scratch[_SA + s, i]
            u5 += _E5[s] * scratch[_SV + s, i]
            u3 += _E3[s] * scratch[_SV + s, i]
        speed = tolerance * fastest
        worst5 = max(worst5, abs(v5) * h / speed, abs(u5) / speed)
        worst3 = max(worst3, abs(v3) * h / speed, abs(u3) / speed)
    if worst5 == 0.0 and worst3 == 0.0:
        return 0.0
    return worst5 * worst5 / sqrt(worst5 * worst5 + 0.01 * worst3 * worst3)


@jit
def dop853_step(state, constants, scratch, n_left, n_right):
    """One tick in as many accepted steps as the tolerance asks for."""
    n = int(constants[SCALARS, GRAINS])
    step, tolerance = constants[SCALARS, STEP], constants[SCALARS, TOLERANCE]
    u, v = state[U], state[V]
    left_base, right_base = u[1], u[n]
    kernels.place_pistons(u, v, constants, scratch, n_left, n_right, left_base, right_base, 0.0)
    for s in range(_STAGES):
        scratch[_SA + s][:] = 0.0
    e, trial = 0.0, 1.0
    while e < 1.0:
        part = min(trial, 1.0 - e)
        closing = _time_to_close(u, v, constants, n)
        if closing > _SMALLEST_PART:
            part = min(part, closing)
        last = part >= 1.0 - e
        _stages(u, v, constants, scratch, n_left, n_right, left_base, right_base, e, part, n)
        error = _error(u, v, scratch, step * part, n, tolerance)
        if not (error <= 1.0) and part > _SMALLEST_PART:
            shrink = _SAFETY / sqrt(sqrt(sqrt(error))) if error < 1e100 else _SMALLEST_FACTOR
            trial = part * max(_SMALLEST_FACTOR, shrink)
            continue
        for s in range(_STAGES):
            weight = step * part * _B[s]
            sv, sa = scratch[_SV + s], scratch[_SA + s]
            for i in range(1, n + 1):
                u[i] += weight * sv[i]
            for i in range(1, n + 6):
                v[i] += weight * sa[i]
        e = 1.0 if last else e + part
        kernels.place_pistons(u, v, constants, scratch, n_left, n_right, left_base, right_base, e)
        grow = _SAFETY / sqrt(sqrt(sqrt(error))) if error > 1e-12 else _LARGEST_FACTOR
        trial = part * min(_LARGEST_FACTOR, grow)


@jit
def advance_dop853(memory, constants, scratch, drive, left_pieces, tick, ticks):
    """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
    tally, state = kernels.parts(memory, STATE_ROWS, constants.shape[1])
    n = int(constants[SCALARS, GRAINS])
    left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
    right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
    for t in range(tick, tick + ticks):
        left_piece, right_piece, n_left, n_right, _ = kernels.turn(drive, left_pieces, left_piece, right_piece, t, scratch)
        left_before, right_before = state[V, 1], state[V, n]
        dop853_step(state, constants, scratch, n_left, n_right)
        if kernels.finish(tally, state, constants, left_before, right_before):
            return -(t + 1 - tick)
    return -ticks if kernels.unsound(state, constants) else ticks
