"""The backward sweep: the transpose of each drift and kick, in reverse order, at the displacements that the tape kept.

`adjoint` is the adjoint of the table: row by row and column by column the derivative of the objective. In its rows of scratch
lie, while a stage is reversed, for each grain c = kick w v_adjoint (FORCE_ADJOINT, the derivative by the force on it) and the
sum of c times that force (INVERSE_MASS_SUM, w times the derivative by the inverse mass w), for each contact its force (FORCE)
and g = dF/dd times the derivative by that (OVERLAP_ADJOINT, the derivative by its overlap).
"""

from __future__ import annotations

import numpy as np

from ...support.jit import jit
from .. import equations_of_motion as equations
from ..laws import placeholders as law
from ..laws.placeholders import DISSIPATES
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
from .dissipative_step import reverse_dissipation

FORCE_ADJOINT, FORCE, OVERLAP_ADJOINT, INVERSE_MASS_SUM = OLD_VELOCITY, MIN_IMPULSE, IMPULSE_PER_SPEED, LEFT_DRIVE
_ONE = np.uint64(1)


@jit
def _reverse_drift(a, adjoint, kick, drift):
    """Add drift u_adjoint to v_adjoint, and the effect on the adjoint of the force on each grain, in the kick before."""
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        v = adjoint[V, i] + drift * adjoint[U, i]
        adjoint[V, i] = v
        adjoint[FORCE_ADJOINT, i] = (kick * a[INVERSE_MASS, i]) * v


@jit
def _reverse_forces(a, adjoint, row):
    """Carry adjoints from the forces on the grains to the contacts: constants, overlap."""
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        force_adjoint = adjoint[FORCE_ADJOINT, j + _ONE] - adjoint[FORCE_ADJOINT, j]
        d = equations.pressed(a[row, j] - a[row, j + _ONE] + a[REST_OVERLAP, j])
        force, by_overlap, by_stiffness = law.force_slopes(a, j, d)
        g = by_overlap * force_adjoint
        adjoint[OVERLAP_ADJOINT, j] = g
        adjoint[FORCE, j] = force
        adjoint[REST_OVERLAP, j] += g
        adjoint[STIFFNESS, j] += by_stiffness * force_adjoint


@jit
def _reverse_overlaps(a, adjoint):
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        adjoint[U, i] += adjoint[OVERLAP_ADJOINT, i] - adjoint[OVERLAP_ADJOINT, i - _ONE]
        adjoint[INVERSE_MASS_SUM, i] += adjoint[FORCE_ADJOINT, i] * (adjoint[FORCE, i - _ONE] - adjoint[FORCE, i])


@jit
def _reverse_ends(a, adjoint, e, input_adjoint):
    """Replace the forces of the missing contacts at free ends by the forces on those ends."""
    n = int(a[SCALARS, GRAINS])
    if a[SCALARS, LEFT_KIND] == FREE:
        adjoint[FORCE, 0] = a[SCALARS, LEFT_STATIC] + equations.value(a, LEFT_DRIVE, 1, e)
        input_adjoint[0] += adjoint[FORCE_ADJOINT, 1]
        adjoint[SCALARS, LEFT_STATIC] += adjoint[FORCE_ADJOINT, 1]
    if a[SCALARS, RIGHT_KIND] == FREE:
        adjoint[FORCE, n] = a[SCALARS, RIGHT_STATIC] - equations.value(a, RIGHT_DRIVE, 1, e)
        input_adjoint[1] += adjoint[FORCE_ADJOINT, n]
        adjoint[SCALARS, RIGHT_STATIC] -= adjoint[FORCE_ADJOINT, n]


@jit
def _reverse_gravity(a, adjoint, kick):
    low = 2 if a[SCALARS, LEFT_KIND] == PISTON else 1
    high = int(a[SCALARS, GRAINS]) + (0 if a[SCALARS, RIGHT_KIND] == PISTON else 1)
    total = 0.0
    for i in range(low, high):
        total += adjoint[V, i]
    adjoint[SCALARS, GRAVITY] += kick * total


@jit
def _reverse_pistons(a, adjoint, bases, input_adjoint, e):
    """Prescribed grains, a part e of a step after the tick: their place is the base and the input's integral."""
    h = a[SCALARS, STEP]
    if a[SCALARS, LEFT_KIND] == PISTON:
        bases[0] += adjoint[U, 1]
        input_adjoint[0] += h * e * adjoint[U, 1]
        adjoint[U, 1] = 0.0
    if a[SCALARS, RIGHT_KIND] == PISTON:
        n = int(a[SCALARS, GRAINS])
        bases[1] += adjoint[U, n]
        input_adjoint[1] += h * e * adjoint[U, n]
        adjoint[U, n] = 0.0


@jit
def reverse_piston_speeds(a, adjoint, input_adjoint):
    """Prescribed grains' velocities are the inputs."""
    if a[SCALARS, LEFT_KIND] == PISTON:
        input_adjoint[0] += adjoint[V, 1]
        adjoint[V, 1] = 0.0
    if a[SCALARS, RIGHT_KIND] == PISTON:
        n = int(a[SCALARS, GRAINS])
        input_adjoint[1] += adjoint[V, n]
        adjoint[V, n] = 0.0


@jit
def reverse_step(a, adjoint, left, right, ticks, row, drifts, kicks, passed, input_adjoint, bases):
    """Reverse the control step whose tape ends before `row`: `adjoint` goes from its end to its begin.

    What the inputs of that step have contributed is added to `input_adjoint`.
    """
    n, stages, h = int(a[SCALARS, GRAINS]), len(kicks), a[SCALARS, STEP]
    a[LEFT_DRIVE, 0], a[RIGHT_DRIVE, 0] = left, right
    for _ in range(ticks):
        bases[0], bases[1] = 0.0, 0.0
        reverse_piston_speeds(a, adjoint, input_adjoint)
        _reverse_pistons(a, adjoint, bases, input_adjoint, passed[stages - 1] + drifts[stages])
        for back in range(stages):
            s = stages - 1 - back
            e = drifts[0] if s == 0 else passed[s - 1] + drifts[s]
            row -= 1
            _reverse_drift(a, adjoint, kicks[s] * h, drifts[s + 1] * h)
            if DISSIPATES and s == stages // 2:
                # The speeds of pistons meanwhile are the inputs, and before and after it they do not matter.
                adjoint[V, 1] = 0.0 if a[SCALARS, LEFT_KIND] == PISTON else adjoint[V, 1]
                adjoint[V, n] = 0.0 if a[SCALARS, RIGHT_KIND] == PISTON else adjoint[V, n]
                row -= 1
                reverse_dissipation(a, adjoint, row, row + 1, h)
                reverse_piston_speeds(a, adjoint, input_adjoint)
            else:
                _reverse_forces(a, adjoint, row)
                _reverse_ends(a, adjoint, passed[s], input_adjoint)
                if a[SCALARS, GRAVITY] != 0.0:
                    _reverse_gravity(a, adjoint, kicks[s] * h)
                _reverse_overlaps(a, adjoint)
            _reverse_pistons(a, adjoint, bases, input_adjoint, e)
        _reverse_drift(a, adjoint, 0.0, drifts[0] * h)
        if a[SCALARS, LEFT_KIND] == PISTON:
            adjoint[U, 1], adjoint[V, 1] = bases[0], 0.0
        if a[SCALARS, RIGHT_KIND] == PISTON:
            adjoint[U, n], adjoint[V, n] = bases[1], 0.0
    return row
