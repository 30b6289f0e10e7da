"""The transpose of `integrators.dissipation`: of its three half sweeps, and of what they are prepared from."""

from __future__ import annotations

from math import sqrt

import numpy as np

from ...jit import inlined, jit
from ..integrators.dissipation import half_sweep, prepare
from ..laws import dispatch
from ..table import (
    BOUND,
    CONTACT,
    DISSIPATION,
    GRAINS,
    GRIP,
    INVERSE_MASS,
    KUWABARA_KONO,
    REST,
    RIGHT_DRIVE,
    SCALARS,
    SMALLEST_OVERLAP,
    STIFFNESS,
    UNLOADING,
    VISCOUS,
    U,
    V,
)

# Scratch of the adjoint table: speed of approach before the first two half sweeps, and before the third.
_APPROACH, _LAST_APPROACH = RIGHT_DRIVE, UNLOADING
_ONE, _TWO = np.uint64(1), np.uint64(2)


@jit
def _note_approach(a, bar, row, first):
    for j in range(np.uint64(first), np.uint64(int(a[SCALARS, GRAINS]) + 1), _TWO):
        bar[row, j] = a[V, j] - a[V, j + _ONE]


@jit
def _undo_half_sweep(a, bar, row, first):
    """Of one parity: grip and bound of each contact, inverse masses, velocities."""
    for j in range(np.uint64(first), np.uint64(int(a[SCALARS, GRAINS]) + 1), _TWO):
        approach, left, right = bar[row, j], bar[V, j], bar[V, j + _ONE]
        free = a[GRIP, j] * approach
        held = free > a[BOUND, j]
        impulse = free if held else a[BOUND, j]
        impulse_bar = a[INVERSE_MASS, j + _ONE] * right - a[INVERSE_MASS, j] * left
        bar[INVERSE_MASS, j] -= impulse * left
        bar[INVERSE_MASS, j + _ONE] += impulse * right
        given = impulse_bar if held else 0.0
        bar[GRIP, j] += given * approach
        bar[BOUND, j] += impulse_bar - given
        bar[V, j] = left + a[GRIP, j] * given
        bar[V, j + _ONE] = right - a[GRIP, j] * given


@inlined
def _unprepared(kind, a, bar, u, h):
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        d = a[u, j] - a[u, j + _ONE] + a[REST, j]
        d = 0.0 if d < SMALLEST_OVERLAP else d
        root = sqrt(d)
        time = h * (0.5 + 0.5 * np.float64(np.int64(j & _ONE)))
        masses = a[INVERSE_MASS, j] + a[INVERSE_MASS, j + _ONE]
        pull = dispatch.coefficient(kind, a, j, d) * time
        y = 0.5 * pull * masses
        # Grip = pull q(y), q = (1 + y) / (1 + 2 y + 2 y^2).
        below = 1.0 / (1.0 + 2.0 * y * (1.0 + y))
        q, slope = (1.0 + y) * below, -(1.0 + y * (4.0 + 2.0 * y)) * (below * below)
        grip_bar, bound_bar = bar[GRIP, j], bar[BOUND, j]
        pull_bar = grip_bar * (q + y * slope) * time
        masses_bar = grip_bar * (0.5 * pull * pull) * slope
        bar[INVERSE_MASS, j] += masses_bar
        bar[INVERSE_MASS, j + _ONE] += masses_bar
        bar[STIFFNESS, j] -= bound_bar * time * (d * root)
        g = -1.5 * (a[STIFFNESS, j] * root) * time * bound_bar
        if kind == VISCOUS:
            bar[CONTACT, j] += pull_bar if d > 0.0 else 0.0
        else:
            bar[CONTACT, j] += pull_bar * root
            g += 0.5 * a[CONTACT, j] / root * pull_bar if d > 0.0 else 0.0
        bar[REST, j] += g
        bar[GRIP, j], bar[BOUND, j] = g, 0.0


@jit
def undo_dissipation(a, bar, u, v, h):
    """Undo the flow of the dissipative forces over a time h, displacements in row u, velocities before it in row v."""
    n = int(a[SCALARS, GRAINS])
    for i in range(np.uint64(n + 2)):
        a[V, i] = a[v, i]
        bar[GRIP, i], bar[BOUND, i] = 0.0, 0.0
    prepare(a, u, h)
    _note_approach(a, bar, _APPROACH, 0)
    half_sweep(a, 0)
    _note_approach(a, bar, _APPROACH, 1)
    half_sweep(a, 1)
    _note_approach(a, bar, _LAST_APPROACH, 0)
    _undo_half_sweep(a, bar, _LAST_APPROACH, 0)
    _undo_half_sweep(a, bar, _APPROACH, 1)
    _undo_half_sweep(a, bar, _APPROACH, 0)
    bar[V, 0], bar[V, n + 1] = 0.0, 0.0
    if a[SCALARS, DISSIPATION] == VISCOUS:
        _unprepared(VISCOUS, a, bar, u, h)
    else:
        _unprepared(KUWABARA_KONO, a, bar, u, h)
    for i in range(np.uint64(1), np.uint64(n + 1)):
        bar[U, i] += bar[GRIP, i] - bar[GRIP, i - _ONE]
