"""The transpose of `integrators.dissipation`: of its three half sweeps, and of what they are prepared from."""

from __future__ import annotations

import numpy as np

from ...support.jit import inlined, jit
from .. import kernels
from ..integrators.dissipation import closed_time, is_closing, prepare
from ..laws import functions as law
from ..laws.functions import JUMPS
from ..layout import (
    DISSIPATED,
    GRAINS,
    HISTORY,
    IMPULSE_PER_SPEED,
    INVERSE_MASS,
    MIN_IMPULSE,
    REST_OVERLAP,
    RIGHT_DRIVE,
    SCALARS,
    STIFFNESS,
    U,
    V,
)

# Scratch of the adjoint table: the speeds of approach before each half sweep, and what goes from contacts to grains.
_APPROACHES = (RIGHT_DRIVE, HISTORY, HISTORY + 1)
_PASSED_ON, _IMPULSE = HISTORY + 2, DISSIPATED
_ONE = np.uint64(1)


@inlined
def _impulse(a, bar, approach, odd, j):
    """Of a contact in a half sweep of one parity: its impulse, and whether that grows with the approach; the others rest.

    A row of which every other entry rests is quicker than every other entry of a row.
    """
    acts = np.int64(j & _ONE) == odd
    free = a[IMPULSE_PER_SPEED, j] * bar[approach, j]
    held = free > a[MIN_IMPULSE, j]
    impulse = free if held else a[MIN_IMPULSE, j]
    return impulse if acts else 0.0, held, acts


@jit
def _half_sweep(a, bar, approach, odd):
    """`integrators.dissipation.half_sweep`, which notes the speeds of approach before it."""
    n = int(a[SCALARS, GRAINS])
    for j in range(np.uint64(0), np.uint64(n + 1)):
        bar[approach, j] = a[V, j] - a[V, j + _ONE]
    for j in range(np.uint64(0), np.uint64(n + 1)):
        bar[_IMPULSE, j], _, _ = _impulse(a, bar, approach, odd, j)
    for i in range(np.uint64(1), np.uint64(n + 1)):
        a[V, i] += a[INVERSE_MASS, i] * (bar[_IMPULSE, i - _ONE] - bar[_IMPULSE, i])


@jit
def _undo_half_sweep(a, bar, approach, odd):
    """Of one parity: grip and bound of each contact, inverse masses, velocities."""
    n = int(a[SCALARS, GRAINS])
    for j in range(np.uint64(0), np.uint64(n + 1)):
        impulse, held, acts = _impulse(a, bar, approach, odd, j)
        impulse_bar = a[INVERSE_MASS, j + _ONE] * bar[V, j + _ONE] - a[INVERSE_MASS, j] * bar[V, j]
        impulse_bar = impulse_bar if acts else 0.0
        given = impulse_bar if held else 0.0
        bar[IMPULSE_PER_SPEED, j] += given * bar[approach, j]
        bar[MIN_IMPULSE, j] += impulse_bar - given
        bar[_PASSED_ON, j] = a[IMPULSE_PER_SPEED, j] * given
        bar[_IMPULSE, j] = impulse
    for i in range(np.uint64(1), np.uint64(n + 1)):
        v = bar[V, i]
        bar[INVERSE_MASS, i] += v * (bar[_IMPULSE, i - _ONE] - bar[_IMPULSE, i])
        bar[V, i] = v + (bar[_PASSED_ON, i] - bar[_PASSED_ON, i - _ONE])


@jit
def _undo_preparation(a, bar, u, h):
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        middle, w = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j], bar[_APPROACHES[0], j]
        d = kernels.pressed(middle)
        share = 0.5 + 0.5 * np.float64(np.int64(j & _ONE))
        time = (closed_time(middle, w, h) if JUMPS else h) * share
        masses = a[INVERSE_MASS, j] + a[INVERSE_MASS, j + _ONE]
        coefficient = law.coefficient(a, j, d)
        pull = coefficient * time
        y = 0.5 * pull * masses
        # The impulse per speed is pull q(y), q = (1 + y) / (1 + 2 y + 2 y^2).
        below = 1.0 / (1.0 + 2.0 * y * (1.0 + y))
        q, slope = (1.0 + y) * below, -(1.0 + y * (4.0 + 2.0 * y)) * (below * below)
        grip_bar, bound_bar = bar[IMPULSE_PER_SPEED, j], bar[MIN_IMPULSE, j]
        pull_bar = grip_bar * (q + y * slope)
        masses_bar = grip_bar * (0.5 * pull * pull) * slope
        bar[INVERSE_MASS, j] += masses_bar
        bar[INVERSE_MASS, j + _ONE] += masses_bar
        f_bar = -bound_bar * time
        force, by_overlap, by_stiffness = law.force_slopes(a, j, d)
        bar[STIFFNESS, j] += by_stiffness * f_bar
        g = by_overlap * f_bar + law.coefficient_pullback(a, bar, j, d, pull_bar * time)
        approach_bar = 0.0
        if JUMPS:
            if is_closing(middle, w, h):
                time_bar = share * (pull_bar * coefficient - bound_bar * force)
                g += time_bar / w
                approach_bar = -time_bar * middle / (w * w)
        bar[REST_OVERLAP, j] += g
        bar[IMPULSE_PER_SPEED, j], bar[MIN_IMPULSE, j] = g, approach_bar


@jit
def undo_dissipation(a, bar, u, v, h):
    """Undo the flow of the dissipative forces over a time h, displacements in row u, velocities before it in row v."""
    n = int(a[SCALARS, GRAINS])
    for i in range(np.uint64(n + 2)):
        a[V, i] = a[v, i]
        bar[IMPULSE_PER_SPEED, i], bar[MIN_IMPULSE, i] = 0.0, 0.0
    prepare(a, u, h)
    _half_sweep(a, bar, _APPROACHES[0], 0)
    _half_sweep(a, bar, _APPROACHES[1], 1)
    for j in range(np.uint64(n + 1)):
        bar[_APPROACHES[2], j] = a[V, j] - a[V, j + _ONE]
    _undo_half_sweep(a, bar, _APPROACHES[2], 0)
    _undo_half_sweep(a, bar, _APPROACHES[1], 1)
    _undo_half_sweep(a, bar, _APPROACHES[0], 0)
    _undo_preparation(a, bar, u, h)
    for i in range(np.uint64(1), np.uint64(n + 1)):
        bar[U, i] += bar[IMPULSE_PER_SPEED, i] - bar[IMPULSE_PER_SPEED, i - _ONE]
        bar[V, i] += bar[MIN_IMPULSE, i] - bar[MIN_IMPULSE, i - _ONE]
