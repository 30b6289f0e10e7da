"""The loops over control steps: forward, with checkpoints; and backward, from one checkpoint to the one before.

Objectives are reached through addresses (`jit.caller`), so that one compilation serves all of them.
"""

from __future__ import annotations

import numpy as np

from ...support.addresses import caller
from ...support.jit import jit
from ..integrators import SIGNATURE
from ..layout import (
    DISSIPATED,
    FREE_ROW,
    GRAINS,
    INVERSE_MASS,
    LEFT_DRIVE,
    SCALARS,
    U,
    V,
)
from .backward import INVERSE_MASS_SUM, reverse_step
from .tape import record, rows_per_tick

NOTE = "void(float64[:, ::1], int64, int64, float64[::1], float64[::1], float64[::1])"
PULLBACK = (
    "void(float64[:, ::1], float64[:, ::1], int64, int64, float64[::1], float64[::1], float64[::1], float64[::1])"
)  # fmt: skip

_advance, _note, _pullback = caller(SIGNATURE), caller(NOTE), caller(PULLBACK)

# How a run ends, beside the control step in which it does.
DONE, STEP_FAILED, NOTE_FAILED, PULLBACK_FAILED, REVERSE_FAILED = range(5)
_LARGEST = np.finfo(np.float64).max


@jit
def _keep_state(a, saved, block):
    for i in range(np.uint64(a.shape[1])):
        saved[block, 0, i] = a[U, i]
        saved[block, 1, i] = a[V, i]


@jit
def _finite(values):
    for i in range(len(values)):
        if not np.isfinite(values[i]):
            return False
    return True


@jit
def _unsound(adjoint):
    """Return whether a derivative by the state is infinite or not a number."""
    found = False
    for i in range(np.uint64(adjoint.shape[1])):
        found |= not (abs(adjoint[U, i]) <= _LARGEST and abs(adjoint[V, i]) <= _LARGEST)
    return found


@jit
def forward(a, advance, note, drive, no_pieces, tick, ticks, constants, sums, saved, interval):
    """Run all control steps, the state kept in `saved` every `interval` of them; returns (control step, how it ended)."""
    steps, no_piece = drive.shape[0], np.int64(0)
    for step in range(steps):
        if saved.shape[0] > 0 and step % interval == 0:
            _keep_state(a, saved, step // interval)
        left, right = drive[step, 0], drive[step, 1]
        if _advance(advance, (a, no_pieces, no_piece, left, right, tick + step * ticks, ticks)) != ticks:
            return step, STEP_FAILED
        _note(note, (a, step, steps, drive[step], constants, sums))
        if not _finite(sums):
            return step, NOTE_FAILED
    return steps, DONE


@jit
def backward(
    a, adjoint, pullback, drive, ticks, constants, slopes, saved, interval, drifts, kicks, passed, input_adjoints, bases
):  # fmt: skip
    """Go from the last checkpoint to the first: record an interval, then reverse it; return (control step, how it ended).

    The tape lies in `a` behind the chain's own rows: for each control step that of the integrator, then the state at its end.
    """
    steps, columns = drive.shape[0], np.uint64(a.shape[1])
    step_rows = ticks * rows_per_tick(len(kicks))
    for back in range(saved.shape[0]):
        block = saved.shape[0] - 1 - back
        begin, end = block * interval, min(steps, (block + 1) * interval)
        for i in range(columns):
            a[U, i], a[V, i] = saved[block, 0, i], saved[block, 1, i]
        row = FREE_ROW + 1
        for step in range(begin, end):
            row = record(a, drive[step, 0], drive[step, 1], ticks, row, drifts, kicks, passed)
            for i in range(columns):
                a[row, i], a[row + 1, i] = a[U, i], a[V, i]
            row += 2
        for ahead in range(end - begin):
            step = end - 1 - ahead
            row -= 2
            for i in range(columns):
                a[U, i], a[V, i] = a[row, i], a[row + 1, i]
            inputs, input_adjoint = drive[step], input_adjoints[step]
            _pullback(pullback, (a, adjoint, step, steps, inputs, input_adjoint, constants, slopes))
            if _unsound(adjoint):
                return step, PULLBACK_FAILED
            reverse_step(a, adjoint, drive[step, 0], drive[step, 1], ticks, row, drifts, kicks, passed, input_adjoint, bases)
            row -= step_rows
            if _unsound(adjoint):
                return step, REVERSE_FAILED
    _finish_sums(a, adjoint)
    return steps, DONE


@jit
def _finish_sums(a, adjoint):
    """Finish the sums that ran in other units, and leave no scratch behind."""
    for i in range(1, int(a[SCALARS, GRAINS]) + 1):
        if a[INVERSE_MASS, i] > 0.0:
            adjoint[INVERSE_MASS, i] += adjoint[INVERSE_MASS_SUM, i] / a[INVERSE_MASS, i]
    for row in range(LEFT_DRIVE, DISSIPATED + 1):
        for i in range(a.shape[1]):
            adjoint[row, i] = 0.0
