"""The backward sweep: the transpose of each drift and kick, in reverse order, at the displacements that the tape kept.

`bar` is the adjoint of the table: row by row and column by column the derivative of the objective. In its rows of scratch lie,
while a stage is undone, for each grain c = kick w v_bar (the derivative by the force on it) and the sum of c times that force
(w times the derivative by w, the inverse mass), for each contact its force and g = dF/dd F_bar (the derivative by its overlap).
"""

from __future__ import annotations

import numpy as np

from ...support.jit import jit
from .. import kernels
from ..laws import functions as law
from ..laws.functions import DISSIPATES
from ..layout import (
    FREE,
    GRAINS,
    GRAVITY,
    IMPULSE_PER_SPEED,
    INVERSE_MASS,
    LEFT_DRIVE,
    LEFT_KIND,
    LEFT_STATIC,
    MIN_IMPULSE,
    OLD_VELOCITY,
    PISTON,
    REST_OVERLAP,
    RIGHT_DRIVE,
    RIGHT_KIND,
    RIGHT_STATIC,
    SCALARS,
    STEP,
    STIFFNESS,
    U,
    V,
)
from .dissipation import undo_dissipation

PUSH, FORCE, SLOPE, WORTH = OLD_VELOCITY, MIN_IMPULSE, IMPULSE_PER_SPEED, LEFT_DRIVE
_ONE = np.uint64(1)


@jit
def _undo_drift(a, bar, kick, drift):
    """Add drift u_bar to v_bar, and the effect on the adjoint of the force on each grain, in the kick before."""
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        v = bar[V, i] + drift * bar[U, i]
        bar[V, i] = v
        bar[PUSH, i] = (kick * a[INVERSE_MASS, i]) * v


@jit
def _undo_forces(a, bar, row):
    """From the forces on the grains to the contacts: constants, overlap."""
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        f_bar = bar[PUSH, j + _ONE] - bar[PUSH, j]
        d = kernels.pressed(a[row, j] - a[row, j + _ONE] + a[REST_OVERLAP, j])
        force, by_overlap, by_stiffness = law.force_slopes(a, j, d)
        g = by_overlap * f_bar
        bar[SLOPE, j] = g
        bar[FORCE, j] = force
        bar[REST_OVERLAP, j] += g
        bar[STIFFNESS, j] += by_stiffness * f_bar


@jit
def _undo_overlaps(a, bar):
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        bar[U, i] += bar[SLOPE, i] - bar[SLOPE, i - _ONE]
        bar[WORTH, i] += bar[PUSH, i] * (bar[FORCE, i - _ONE] - bar[FORCE, i])


@jit
def _undo_ends(a, bar, e, input_bar):
    """Replace the forces of the missing contacts at free ends by the forces on those ends."""
    n = int(a[SCALARS, GRAINS])
    if a[SCALARS, LEFT_KIND] == FREE:
        bar[FORCE, 0] = a[SCALARS, LEFT_STATIC] + kernels.value(a, LEFT_DRIVE, 1, e)
        input_bar[0] += bar[PUSH, 1]
        bar[SCALARS, LEFT_STATIC] += bar[PUSH, 1]
    if a[SCALARS, RIGHT_KIND] == FREE:
        bar[FORCE, n] = a[SCALARS, RIGHT_STATIC] - kernels.value(a, RIGHT_DRIVE, 1, e)
        input_bar[1] += bar[PUSH, n]
        bar[SCALARS, RIGHT_STATIC] -= bar[PUSH, n]


@jit
def _undo_gravity(a, bar, kick):
    low = 2 if a[SCALARS, LEFT_KIND] == PISTON else 1
    high = int(a[SCALARS, GRAINS]) + (0 if a[SCALARS, RIGHT_KIND] == PISTON else 1)
    total = 0.0
    for i in range(low, high):
        total += bar[V, i]
    bar[SCALARS, GRAVITY] += kick * total


@jit
def _take_pistons(a, bar, bases, input_bar, e):
    """Prescribed grains, a part e of a step after the tick: their place is the base and the input's integral."""
    h = a[SCALARS, STEP]
    if a[SCALARS, LEFT_KIND] == PISTON:
        bases[0] += bar[U, 1]
        input_bar[0] += h * e * bar[U, 1]
        bar[U, 1] = 0.0
    if a[SCALARS, RIGHT_KIND] == PISTON:
        n = int(a[SCALARS, GRAINS])
        bases[1] += bar[U, n]
        input_bar[1] += h * e * bar[U, n]
        bar[U, n] = 0.0


@jit
def take_piston_speeds(a, bar, input_bar):
    """Prescribed grains' velocities are the inputs."""
    if a[SCALARS, LEFT_KIND] == PISTON:
        input_bar[0] += bar[V, 1]
        bar[V, 1] = 0.0
    if a[SCALARS, RIGHT_KIND] == PISTON:
        n = int(a[SCALARS, GRAINS])
        input_bar[1] += bar[V, n]
        bar[V, n] = 0.0


@jit
def undo(a, bar, left, right, ticks, row, drifts, kicks, passed, input_bar, bases):
    """Undo the control step whose tape ends before `row`: bar goes from its end to its begin; input_bar grows by its share."""
    n, stages, h = int(a[SCALARS, GRAINS]), len(kicks), a[SCALARS, STEP]
    a[LEFT_DRIVE, 0], a[RIGHT_DRIVE, 0] = left, right
    for _ in range(ticks):
        bases[0], bases[1] = 0.0, 0.0
        take_piston_speeds(a, bar, input_bar)
        _take_pistons(a, bar, bases, input_bar, passed[stages - 1] + drifts[stages])
        for back in range(stages):
            s = stages - 1 - back
            e = drifts[0] if s == 0 else passed[s - 1] + drifts[s]
            row -= 1
            _undo_drift(a, bar, kicks[s] * h, drifts[s + 1] * h)
            if DISSIPATES and s == stages // 2:
                # The speeds of pistons meanwhile are the inputs, and before and after it they do not matter.
                bar[V, 1] = 0.0 if a[SCALARS, LEFT_KIND] == PISTON else bar[V, 1]
                bar[V, n] = 0.0 if a[SCALARS, RIGHT_KIND] == PISTON else bar[V, n]
                row -= 1
                undo_dissipation(a, bar, row, row + 1, h)
                take_piston_speeds(a, bar, input_bar)
            else:
                _undo_forces(a, bar, row)
                _undo_ends(a, bar, passed[s], input_bar)
                if a[SCALARS, GRAVITY] != 0.0:
                    _undo_gravity(a, bar, kicks[s] * h)
                _undo_overlaps(a, bar)
            _take_pistons(a, bar, bases, input_bar, e)
        _undo_drift(a, bar, 0.0, drifts[0] * h)
        if a[SCALARS, LEFT_KIND] == PISTON:
            bar[U, 1], bar[V, 1] = bases[0], 0.0
        if a[SCALARS, RIGHT_KIND] == PISTON:
            bar[U, n], bar[V, n] = bases[1], 0.0
    return row
