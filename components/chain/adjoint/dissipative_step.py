"""The reverse of `integrators.dissipative_step`: of its three half sweeps, and of what they are prepared from."""

from __future__ import annotations

import numpy as np

from ...support.jit import inlined, jit
from .. import equations_of_motion as equations
from ..integrators.dissipative_step import closed_time, is_closing, prepare
from ..laws import placeholders as law
from ..laws.placeholders import JUMPS
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
_SPEED_ADJOINT, _IMPULSE = HISTORY + 2, DISSIPATED
_ONE = np.uint64(1)


@inlined
def _impulse(a, adjoint, approach, odd, j):
    """Return a contact's impulse in a half sweep of one parity, and whether that grows with the approach; the others rest.

    A row of which every other entry rests is quicker than every other entry of a row.
    """
    acts = np.int64(j & _ONE) == odd
    free = a[IMPULSE_PER_SPEED, j] * adjoint[approach, j]
    held = free > a[MIN_IMPULSE, j]
    impulse = free if held else a[MIN_IMPULSE, j]
    return impulse if acts else 0.0, held, acts


@jit
def _half_sweep(a, adjoint, approach, odd):
    """`integrators.dissipative_step.half_sweep`, which notes the speeds of approach before it."""
    n = int(a[SCALARS, GRAINS])
    for j in range(np.uint64(0), np.uint64(n + 1)):
        adjoint[approach, j] = a[V, j] - a[V, j + _ONE]
    for j in range(np.uint64(0), np.uint64(n + 1)):
        adjoint[_IMPULSE, j], _, _ = _impulse(a, adjoint, approach, odd, j)
    for i in range(np.uint64(1), np.uint64(n + 1)):
        a[V, i] += a[INVERSE_MASS, i] * (adjoint[_IMPULSE, i - _ONE] - adjoint[_IMPULSE, i])


@jit
def _reverse_half_sweep(a, adjoint, approach, odd):
    """Reverse a half sweep: to impulses per speed and least impulses of one parity, inverse masses, velocities."""
    n = int(a[SCALARS, GRAINS])
    for j in range(np.uint64(0), np.uint64(n + 1)):
        impulse, held, acts = _impulse(a, adjoint, approach, odd, j)
        impulse_adjoint = a[INVERSE_MASS, j + _ONE] * adjoint[V, j + _ONE] - a[INVERSE_MASS, j] * adjoint[V, j]
        impulse_adjoint = impulse_adjoint if acts else 0.0
        given = impulse_adjoint if held else 0.0
        adjoint[IMPULSE_PER_SPEED, j] += given * adjoint[approach, j]
        adjoint[MIN_IMPULSE, j] += impulse_adjoint - given
        adjoint[_SPEED_ADJOINT, j] = a[IMPULSE_PER_SPEED, j] * given
        adjoint[_IMPULSE, j] = impulse
    for i in range(np.uint64(1), np.uint64(n + 1)):
        v = adjoint[V, i]
        adjoint[INVERSE_MASS, i] += v * (adjoint[_IMPULSE, i - _ONE] - adjoint[_IMPULSE, i])
        adjoint[V, i] = v + (adjoint[_SPEED_ADJOINT, i] - adjoint[_SPEED_ADJOINT, i - _ONE])


@jit
def _reverse_preparation(a, adjoint, u, h):
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        middle, w = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j], adjoint[_APPROACHES[0], j]
        d = equations.pressed(middle)
        share = 0.5 + 0.5 * np.float64(np.int64(j & _ONE))
        time = (closed_time(middle, w, h) if JUMPS else h) * share
        masses = a[INVERSE_MASS, j] + a[INVERSE_MASS, j + _ONE]
        coefficient = law.coefficient(a, j, d)
        damping = coefficient * time
        y = 0.5 * damping * masses
        # The impulse per speed is damping q(y), q = (1 + y) / (1 + 2 y + 2 y^2).
        below = 1.0 / (1.0 + 2.0 * y * (1.0 + y))
        q, slope = (1.0 + y) * below, -(1.0 + y * (4.0 + 2.0 * y)) * (below * below)
        slope_adjoint, least_adjoint = adjoint[IMPULSE_PER_SPEED, j], adjoint[MIN_IMPULSE, j]
        damping_adjoint = slope_adjoint * (q + y * slope)
        masses_adjoint = slope_adjoint * (0.5 * damping * damping) * slope
        adjoint[INVERSE_MASS, j] += masses_adjoint
        adjoint[INVERSE_MASS, j + _ONE] += masses_adjoint
        force_adjoint = -least_adjoint * time
        force, by_overlap, by_stiffness = law.force_slopes(a, j, d)
        adjoint[STIFFNESS, j] += by_stiffness * force_adjoint
        g = by_overlap * force_adjoint + law.coefficient_pullback(a, adjoint, j, d, damping_adjoint * time)
        approach_adjoint = 0.0
        if JUMPS:
            if is_closing(middle, w, h):
                time_adjoint = share * (damping_adjoint * coefficient - least_adjoint * force)
                g += time_adjoint / w
                approach_adjoint = -time_adjoint * middle / (w * w)
        adjoint[REST_OVERLAP, j] += g
        adjoint[IMPULSE_PER_SPEED, j], adjoint[MIN_IMPULSE, j] = g, approach_adjoint


@jit
def reverse_dissipation(a, adjoint, u, v, h):
    """Reverse the flow of the dissipative forces over a time h, displacements in row u, velocities before it in row v."""
    n = int(a[SCALARS, GRAINS])
    for i in range(np.uint64(n + 2)):
        a[V, i] = a[v, i]
        adjoint[IMPULSE_PER_SPEED, i], adjoint[MIN_IMPULSE, i] = 0.0, 0.0
    prepare(a, u, h)
    _half_sweep(a, adjoint, _APPROACHES[0], 0)
    _half_sweep(a, adjoint, _APPROACHES[1], 1)
    for j in range(np.uint64(n + 1)):
        adjoint[_APPROACHES[2], j] = a[V, j] - a[V, j + _ONE]
    _reverse_half_sweep(a, adjoint, _APPROACHES[2], 0)
    _reverse_half_sweep(a, adjoint, _APPROACHES[1], 1)
    _reverse_half_sweep(a, adjoint, _APPROACHES[0], 0)
    _reverse_preparation(a, adjoint, u, h)
    for i in range(np.uint64(1), np.uint64(n + 1)):
        adjoint[U, i] += adjoint[IMPULSE_PER_SPEED, i] - adjoint[IMPULSE_PER_SPEED, i - _ONE]
        adjoint[V, i] += adjoint[MIN_IMPULSE, i] - adjoint[MIN_IMPULSE, i - _ONE]
