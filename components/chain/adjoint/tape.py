"""The tape: control steps run once more, keeping the displacements of every kick, for the backward sweep to read.

The arithmetic is that of `integrators.compositions`, and so are the bits: the sweep differentiates the very run that was made.
Kicks read one row of the tape and write the next, so that keeping costs nothing.
"""

from __future__ import annotations

import numpy as np

from ...support.jit import jit
from .. import equations_of_motion as equations
from ..integrators.compositions import kick_and_drift, stage_loop
from ..integrators.dissipative_step import half_sweep, prepare
from ..laws.placeholders import DISSIPATES
from ..layout import (
    FREE,
    GRAINS,
    GRAVITY,
    INVERSE_MASS,
    LEFT_DRIVE,
    LEFT_KIND,
    LEFT_STATIC,
    PISTON,
    RIGHT_DRIVE,
    RIGHT_KIND,
    RIGHT_STATIC,
    SCALARS,
    STEP,
    U,
    V,
)


@jit
def rows_per_tick(stages):
    """Return how many rows an internal step takes: the displacements of each kick; the velocities that dissipation meets."""
    return stages + 1 if DISSIPATES else stages


@jit
def _copy(a, source, target):
    for i in range(np.uint64(int(a[SCALARS, GRAINS]) + 2)):
        a[target, i] = a[source, i]


@jit
def _move(a, here, there, drift):
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        a[there, i] = a[here, i] + drift * a[V, i]


@jit
def _place_pistons(a, row, left_base, right_base, e):
    """Put prescribed grains where they are a part e of a step after the tick."""
    h = a[SCALARS, STEP]
    if a[SCALARS, LEFT_KIND] == PISTON:
        a[row, 1] = left_base + h * equations.integral(a, LEFT_DRIVE, 1, e)
    if a[SCALARS, RIGHT_KIND] == PISTON:
        n = int(a[SCALARS, GRAINS])
        a[row, n] = right_base + h * equations.integral(a, RIGHT_DRIVE, 1, e)


@jit
def _set_piston_speeds(a, e):
    if a[SCALARS, LEFT_KIND] == PISTON:
        a[V, 1] = equations.value(a, LEFT_DRIVE, 1, e)
    if a[SCALARS, RIGHT_KIND] == PISTON:
        a[V, int(a[SCALARS, GRAINS])] = equations.value(a, RIGHT_DRIVE, 1, e)


@jit
def _kick(a, here, there, kick, drift, e):
    n, gravity = int(a[SCALARS, GRAINS]), a[SCALARS, GRAVITY]
    f, pull, first, last = equations.contact(a, here, 0), 0.0, a[V, 1], a[V, n]
    if a[SCALARS, LEFT_KIND] == FREE:
        f = a[SCALARS, LEFT_STATIC] + equations.value(a, LEFT_DRIVE, 1, e)
    if gravity == 0.0:
        f, _ = kick_and_drift(False, False, a, here, there, kick, drift, f, 1, n)
    else:
        f, _ = stage_loop(True, False, a, here, there, kick, drift, f, 1, n)
    if a[SCALARS, RIGHT_KIND] == FREE:
        pull = equations.value(a, RIGHT_DRIVE, 1, e) - a[SCALARS, RIGHT_STATIC]
    fall = 0.0 if a[SCALARS, RIGHT_KIND] == PISTON else kick * gravity
    a[V, n] = (last + (kick * a[INVERSE_MASS, n]) * (f - (equations.contact(a, here, n) - pull))) + fall
    a[there, n] = a[here, n] + drift * a[V, n]
    if a[SCALARS, LEFT_KIND] == PISTON:
        a[V, 1] = first  # gravity does not move it


@jit
def record(a, left, right, ticks, row, drifts, kicks, passed):
    """Advance the state in U and V by a control step of `ticks`, the tape beginning in `row`; returns the next free row."""
    n, stages, h = int(a[SCALARS, GRAINS]), len(kicks), a[SCALARS, STEP]
    a[LEFT_DRIVE, 0], a[RIGHT_DRIVE, 0] = left, right
    here = U
    for _ in range(ticks):
        left_base, right_base = a[here, 1], a[here, n]
        _move(a, here, row, drifts[0] * h)
        _place_pistons(a, row, left_base, right_base, drifts[0])
        for s in range(stages):
            here = row
            row += 1
            # The state at the end of a tick needs no row of its own: the next one moves on from it.
            there = U if s == stages - 1 else row
            if DISSIPATES and s == stages // 2:
                first, last = a[V, 1], a[V, n]
                _set_piston_speeds(a, 0.5)
                _copy(a, V, row)
                row += 1
                there = row
                prepare(a, here, h)
                half_sweep(a, 0)
                half_sweep(a, 1)
                half_sweep(a, 0)
                _move(a, here, there, drifts[s + 1] * h)
                if a[SCALARS, LEFT_KIND] == PISTON:
                    a[V, 1] = first
                if a[SCALARS, RIGHT_KIND] == PISTON:
                    a[V, n] = last
                _place_pistons(a, there, left_base, right_base, 0.5 + drifts[s + 1])
            else:
                _kick(a, here, there, kicks[s] * h, drifts[s + 1] * h, passed[s])
                _place_pistons(a, there, left_base, right_base, passed[s] + drifts[s + 1])
        here = U
        _set_piston_speeds(a, 1.0)
    return row
