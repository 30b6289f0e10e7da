"""The part of a step in which dissipative forces alone act, displacements at rest: pair by pair, each by a formula of its own.

In a contact F = max(c w, -F_e) acts beside the elastic force F_e; the speed of approach w falls as exp(-c s t), s being the sum
of the inverse masses. Over a time t the impulse is the larger of G w and -F_e t, with s G = 1 - 1 / (1 + x + x^2/2) and
x = c s t: of second order, never more than what stops the approach however large c is, and the same momentum for both grains.
Contacts of even number act for half the step, those of odd number for all of it, and the even ones again: a symmetric sequence,
and second order for all of it. T. Shardlow, SIAM J. Sci. Comput. 24 (2003) 1267, splits dissipative particle dynamics so.
A dashpot whose contact closes within the step acts from there on (`closed_time`).
"""

from __future__ import annotations

import numpy as np

from ...support.jit import inlined, jit
from .. import equations_of_motion as equations
from ..laws import placeholders as law
from ..laws.placeholders import JUMPS
from ..layout import (
    DISSIPATED,
    GRAINS,
    IMPULSE_PER_SPEED,
    INVERSE_MASS,
    LEFT_KIND,
    MASS,
    MIN_IMPULSE,
    OLD_VELOCITY,
    PISTON,
    REST_OVERLAP,
    RIGHT_KIND,
    SCALARS,
    SMALLEST_OVERLAP,
    V,
)

_ONE, _TWO = np.uint64(1), np.uint64(2)


# A contact that closes where two steps meet, as round numbers make it, closes in the second: its slope is found there, once.
_EDGE = 1e-3


@inlined
def is_closing(d, w, h):
    """Return whether a contact closes within a step of length h, d its overlap in the middle and w its speed of approach."""
    reach = 0.5 * h * w
    return reach > SMALLEST_OVERLAP and -(1.0 - _EDGE) * reach < d <= (1.0 + _EDGE) * reach


@inlined
def closed_time(d, w, h):
    """Return the part of a step in which a contact is closed; from where it closes, if it does so within the step.

    Without that the dashpot's impulse would jump wherever the closing passes from one step to the next, the order would be 1
    where contacts close, and slopes of the run would be those between two jumps, which no step makes right.
    """
    whole = h if d >= SMALLEST_OVERLAP else 0.0
    return 0.5 * h + d / w if is_closing(d, w, h) else whole


@inlined
def _prepare_contact(a, j, d, closed):
    """Prepare contact j with overlap d, closed for a time `closed` of the step."""
    d = equations.pressed(d)
    time = closed * (0.5 + 0.5 * np.float64(np.int64(j & _ONE)))
    damping = law.coefficient(a, j, d) * time
    half = 0.5 * damping * (a[INVERSE_MASS, j] + a[INVERSE_MASS, j + _ONE])
    a[IMPULSE_PER_SPEED, j] = damping * (1.0 + half) / (1.0 + 2.0 * half * (1.0 + half))
    a[MIN_IMPULSE, j] = -law.force(a, j, d) * time


@inlined
def _prepare_closing(a, u, h):
    """Prepare contacts that close within the step: in a loop of their own, for they are few and cost a division each."""
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        d = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j]
        w = a[V, j] - a[V, j + _ONE]
        if is_closing(d, w, h):
            _prepare_contact(a, j, d, 0.5 * h + d / w)


@jit
def prepare(a, u, h):
    """Write of each contact the impulse per speed of approach, and the one that leaves no pull; the velocities as they are."""
    closing = False
    for j in range(np.uint64(0), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        d = a[u, j] - a[u, j + _ONE] + a[REST_OVERLAP, j]
        closed = h
        if JUMPS:
            closed = h if d >= SMALLEST_OVERLAP else 0.0
            closing |= is_closing(d, a[V, j] - a[V, j + _ONE], h)
        _prepare_contact(a, j, d, closed)
        a[OLD_VELOCITY, j] = a[V, j]
    if JUMPS:
        if closing:
            _prepare_closing(a, u, h)


@inlined
def _impulse(a, j):
    impulse = a[IMPULSE_PER_SPEED, j] * (a[V, j] - a[V, j + _ONE])
    return impulse if impulse > a[MIN_IMPULSE, j] else a[MIN_IMPULSE, j]


@jit
def half_sweep(a, first):
    """All contacts of one parity: no two of them share a grain."""
    for j in range(np.uint64(first), np.uint64(int(a[SCALARS, GRAINS]) + 1), _TWO):
        impulse = _impulse(a, j)
        a[V, j] -= a[INVERSE_MASS, j] * impulse
        a[V, j + _ONE] += a[INVERSE_MASS, j + _ONE] * impulse


@jit
def _note_loss_and_drift(a, u, drift):
    """Note what the grains have lost since `prepare`, and go on with their new velocities."""
    for i in range(np.uint64(1), np.uint64(int(a[SCALARS, GRAINS]) + 1)):
        a[u, i] += drift * a[V, i]
        a[DISSIPATED, i] += 0.5 * a[MASS, i] * ((a[OLD_VELOCITY, i] - a[V, i]) * (a[OLD_VELOCITY, i] + a[V, i]))


@jit
def dissipate_and_drift(a, u, h, drift):
    """Let the dissipative forces act for a time h, displacements in row u; then u += drift v.

    Returns what the ends give the chain: impulse left and right, work left and right.
    """
    n = int(a[SCALARS, GRAINS])
    left = np.uint64(1 if a[SCALARS, LEFT_KIND] == PISTON else 0)
    right = np.uint64(n - 1 if a[SCALARS, RIGHT_KIND] == PISTON else n)
    prepare(a, u, h)
    impulse_left, impulse_right, work_left, work_right = 0.0, 0.0, 0.0, 0.0
    for sweep in range(3):
        parity = np.uint64(sweep & 1)
        if left & _ONE == parity:
            impulse = _impulse(a, left)
            impulse_left, work_left = impulse_left + impulse, work_left + impulse * a[V, left]
        if right & _ONE == parity:
            impulse = _impulse(a, right)
            impulse_right, work_right = impulse_right - impulse, work_right - impulse * a[V, right + _ONE]
        half_sweep(a, parity)
    _note_loss_and_drift(a, u, drift)
    # Pistons have worked against the contacts too.
    a[DISSIPATED, 0] += work_left + work_right
    return impulse_left, impulse_right, work_left, work_right
