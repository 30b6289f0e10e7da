"""Hamming's predictor-corrector with its modifier, the other scheme used by Nesterenko (1983).

R. W. Hamming, J. ACM 6 (1959) 37: p = y_{n-3} + (4h/3)(2 f_n - f_{n-1} + 2 f_{n-2}); the modifier 112/121 and the mop-up 9/121;
two forces per step. The formulas are of order 4; the mop-up removes their leading error, and the measured order is 5. Three
Runge-Kutta steps start the scheme, and restart it when an input jumps. Its history is part of the state.
"""

from __future__ import annotations

from typing import NamedTuple

from ...support.jit import internal
from .. import forces
from ..drive import piece_numbers
from ..layout import FREE_ROW, HISTORY_DRIVE, HISTORY_LENGTH, LIMIT, PEAK, REST_OVERLAP, TALLY, U, V
from . import runge_kutta
from .scheme import advance_tick

# History rows: u and v one, two, three steps ago; dv/dt now, one and two steps ago; predictor minus corrector of u and v.
_U1, _V1, _U2, _V2, _U3, _V3, _A0, _A1, _A2, _GAP_U, _GAP_V = range(11)
HISTORY_ROWS = 11
# Scratch: the Runge-Kutta rows, then predicted and modified u and v, and dv/dt there.
_PU, _PV, _MU, _MV, _MA = range(HISTORY_ROWS + runge_kutta.SCRATCH_ROWS, HISTORY_ROWS + runge_kutta.SCRATCH_ROWS + 5)
SCRATCH_ROWS = runge_kutta.SCRATCH_ROWS + 5


class Hamming(NamedTuple):
    """Coefficients of the scheme, with those of its starting scheme."""

    start: runge_kutta.RungeKutta


HAMMING = Hamming(runge_kutta.RK4)


@advance_tick.register(Hamming)
def hamming_tick(scheme, chain, drive, tick, tape):
    """Advance by one step of the scheme."""
    a, n, before = chain.rows, chain.settings.grains, forces.end_values(chain, chain.rows[V])
    tally, rows, v = a[TALLY], a[FREE_ROW:], forces.velocities_and_tallies(chain)
    left, right = piece_numbers(drive, tick)
    if tick == 0 or tally[HISTORY_DRIVE] != left or tally[HISTORY_DRIVE + 1] != right:
        tally[HISTORY_LENGTH], tally[HISTORY_DRIVE], tally[HISTORY_DRIVE + 1] = 0.0, left, right
        _restart_history(chain, drive)
    if tally[HISTORY_LENGTH] < 3.0:
        _shift_history(chain)
        runge_kutta.runge_kutta_step(scheme.start, chain, drive, rows[HISTORY_ROWS:])
        tally[HISTORY_LENGTH] += 1.0
    else:
        _predict_and_correct(chain, drive)
    forces.copy_array(rows[_A1], rows[_A2])
    forces.copy_array(rows[_A0], rows[_A1])
    forces.accelerations(chain, a[U], v, drive, 1.0, rows[_A0, : len(v)])
    forces.tally_pistons(chain, before)
    return forces.update_peaks(a[U], a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])


@internal
def _restart_history(chain, drive):
    """Discard the history at the start of a run or of a new piece of the drive; Runge-Kutta steps then start the scheme."""
    u, v, rows = forces.displacements(chain), forces.velocities_and_tallies(chain), chain.rows[FREE_ROW:]
    forces.fill_array(rows[_GAP_U], 0.0)
    forces.fill_array(rows[_GAP_V], 0.0)
    forces.place_pistons(chain, u, drive, forces.end_values(chain, u), 0.0)
    forces.set_piston_velocities(chain, v, drive, 0.0)
    forces.accelerations(chain, u, v, drive, 0.0, rows[_A0, : len(v)])


@internal
def _shift_history(chain):
    u, v, rows = forces.displacements(chain), forces.velocities_and_tallies(chain), chain.rows[FREE_ROW:]
    for newer, older in ((_U2, _U3), (_V2, _V3), (_U1, _U2), (_V1, _V2)):
        forces.copy_array(rows[newer], rows[older])
    forces.copy_array(u, rows[_U1])
    forces.copy_array(v, rows[_V1])


@internal
def _predict_and_correct(chain, drive):
    u, v, rows = forces.displacements(chain), forces.velocities_and_tallies(chain), chain.rows[FREE_ROW:]
    h = chain.settings.step
    modified_u, modified_v = rows[_MU, : len(u)], rows[_MV, : len(v)]
    base_positions = forces.end_values(chain, u)
    for i in range(1, len(u) - 1):
        rows[_PU, i] = rows[_U3, i] + 4.0 * h / 3.0 * (2.0 * v[i] - rows[_V1, i] + 2.0 * rows[_V2, i])
        modified_u[i] = rows[_PU, i] - 112.0 / 121.0 * rows[_GAP_U, i]
    for i in range(1, len(v)):
        rows[_PV, i] = rows[_V3, i] + 4.0 * h / 3.0 * (2.0 * rows[_A0, i] - rows[_A1, i] + 2.0 * rows[_A2, i])
        modified_v[i] = rows[_PV, i] - 112.0 / 121.0 * rows[_GAP_V, i]
    forces.place_pistons(chain, modified_u, drive, base_positions, 1.0)
    forces.set_piston_velocities(chain, modified_v, drive, 1.0)
    forces.accelerations(chain, modified_u, modified_v, drive, 1.0, rows[_MA, : len(v)])
    for i in range(1, len(u) - 1):
        c = (9.0 * u[i] - rows[_U2, i]) / 8.0 + 3.0 * h / 8.0 * (modified_v[i] + 2.0 * v[i] - rows[_V1, i])
        rows[_GAP_U, i] = rows[_PU, i] - c
        modified_u[i] = c + 9.0 / 121.0 * (rows[_PU, i] - c)
    for i in range(1, len(v)):
        c = (9.0 * v[i] - rows[_V2, i]) / 8.0 + 3.0 * h / 8.0 * (rows[_MA, i] + 2.0 * rows[_A0, i] - rows[_A1, i])
        rows[_GAP_V, i] = rows[_PV, i] - c
        modified_v[i] = c + 9.0 / 121.0 * (rows[_PV, i] - c)
    _shift_history(chain)
    forces.copy_array(modified_u[1:-1], u[1:-1])
    forces.copy_array(modified_v[1:], v[1:])
    forces.place_pistons(chain, u, drive, base_positions, 1.0)
    forces.set_piston_velocities(chain, v, drive, 1.0)
