"""Quantities of a chain's table for jitted code, with their pullbacks: what sensors, tasks and objectives read.

A quantity is read off the table (`layout.py`): grain i, from 0, is column i + 1; contact j lies between columns j and j + 1, so
that contacts 0 and n are the walls'. `x_pullback(a, bar, ..., slope)` adds slope times the derivative of `x(a, ...)` to `bar`.
Forces have the bits of the component's outputs.

A peak over time is not smooth: it is replaced by the p-norm over the control steps, f0 (sum_t (f_t / f0)^p)^(1/p), p even. It
lies above the largest |f_t|, by a factor of m^(1/p) at most for m equal peaks; `peak_feature` is its summand, `peak_value` the
root.

Roots of the energy measure distances between states in which every motion counts by its energy. A contact that stores the
energy e above that at rest has the root q = +-sqrt(e), negative where it is less pressed than at rest. Two states differ by
sum_i m_i (v_i - v'_i)^2 / 2 + sum_j (q_j - q'_j)^2: the energy itself where the second is at rest. Hertz contacts only: with
s = sqrt(d), d the whole overlap, and s0 that at rest, e = k (s - s0)^2 Q, Q = 0.4 s^3 + 0.8 s^2 s0 + 1.2 s s0^2 + 0.6 s0^3: no
difference of large numbers, whatever the precompression. Without one, q = sqrt(0.4 k) d^1.25. A gap stores nothing.
"""

from __future__ import annotations

import math
from math import sqrt

import numpy as np

from ..support.jit import inlined, jit
from ..support.powers import power
from . import kernels
from .laws import dispatch, hertz
from .laws import power as power_law
from .layout import (
    CONTACT,
    DISSIPATION,
    ELASTIC,
    EXPONENT,
    GRAINS,
    HERTZ,
    MASS,
    NONE,
    POWER,
    REST_OVERLAP,
    SCALARS,
    SMALLEST_OVERLAP,
    STIFFNESS,
    TALLY,
    VISCOUS,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)

# -- contacts and ends, and the work of inputs ---------------------------------------------------------------------------


@jit
def contact_force(a, j):
    """Compressive force in contact j, dissipation included; 0 where there is none."""
    force, _ = kernels._force(int(a[SCALARS, ELASTIC]), int(a[SCALARS, DISSIPATION]), a, U, V, np.uint64(j))
    return force


@jit
def grain_force(a, i):
    """What a sensor inside the grain of column i reads: the mean of the forces in its two contacts."""
    return 0.5 * (contact_force(a, i - 1) + contact_force(a, i))


@inlined
def left_wall_force(a):
    """Force between the left wall and the chain, never negative; 0 without a wall."""
    return contact_force(a, 0)


@inlined
def right_wall_force(a):
    """Force between the chain and the right wall, never negative; 0 without a wall."""
    return contact_force(a, int(a[SCALARS, GRAINS]))


@inlined
def input_work(a):
    """Work done by inputs and boundaries since the reset, as the component's `input_work`."""
    behind = int(a[SCALARS, GRAINS]) + 2
    return (a[TALLY, WORK_LEFT] + a[TALLY, WORK_RIGHT]) + a[V, behind] + a[V, behind + 1]


# -- pullbacks ----------------------------------------------------------------------------------------------------------


@jit
def whole_power(x, p):
    """x^p for a whole p >= 0, by repeated squaring."""
    result, left = 1.0, int(p)
    while left > 0:
        if left % 2 == 1:
            result *= x
        x *= x
        left //= 2
    return result


@jit
def peak_feature(f, scale, p):
    """(f / scale)^p, whose sum over the control steps `peak_value` turns into a smooth maximum."""
    return whole_power(f / scale, p)


@jit
def peak_feature_pullback(f, scale, p):
    """Its derivative by f."""
    return p * whole_power(f / scale, p - 1) / scale


@jit
def peak_value(total, scale, p):
    """The smooth maximum scale total^(1/p), and its derivative by the total; (0, 0) where nothing was felt."""
    if not total > 1e-300:  # NaN too, which must not be hidden
        return scale * total, 0.0
    root = scale * power(total, 1.0 / p)
    return root, root / (p * total)


@inlined
def _overlap(a, j):
    d = a[U, j] - a[U, j + 1] + a[REST_OVERLAP, j]
    return 0.0 if d < SMALLEST_OVERLAP else d


@jit
def _elastic(a, j, d):
    """F / k, and dF/dd / k."""
    if a[SCALARS, ELASTIC] == POWER:
        p = a[SCALARS, EXPONENT]
        if d > SMALLEST_OVERLAP:
            return power(d, p), p * power(d, p - 1.0)
        return 0.0 * d, 0.0
    root = sqrt(d)
    return d * root, 1.5 * root


@jit
def contact_force_pullback(a, bar, j, slope):
    """Adds slope dF/da."""
    d = _overlap(a, j)
    shape, steepness = _elastic(a, j, d)
    steepness *= a[STIFFNESS, j]
    if a[SCALARS, DISSIPATION] != NONE:
        speed = a[V, j] - a[V, j + 1]
        coefficient = dispatch.coefficient(int(a[SCALARS, DISSIPATION]), a, j, d)
        if a[STIFFNESS, j] * shape + coefficient * speed < 0.0:
            return
        bar[V, j] += slope * coefficient
        bar[V, j + 1] -= slope * coefficient
        if d > 0.0 and a[SCALARS, DISSIPATION] == VISCOUS:
            bar[CONTACT, j] += slope * speed
        elif d > 0.0:
            root = sqrt(d)
            bar[CONTACT, j] += slope * root * speed
            steepness += 0.5 * a[CONTACT, j] / root * speed
    bar[STIFFNESS, j] += slope * shape
    bar[U, j] += slope * steepness
    bar[U, j + 1] -= slope * steepness
    bar[REST_OVERLAP, j] += slope * steepness


@jit
def kinetic_energy(a, first, last):
    """Of the grains first..last, from 0 and both included [J]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += 0.5 * a[MASS, i] * a[V, i] * a[V, i]
    return total


@jit
def kinetic_energy_pullback(a, bar, first, last, slope):
    """Adds slope dE/da."""
    for i in range(first + 1, last + 2):
        bar[V, i] += slope * a[MASS, i] * a[V, i]
        bar[MASS, i] += slope * 0.5 * a[V, i] * a[V, i]


@jit
def momentum(a, first, last):
    """Of the grains first..last, from 0 and both included [kg m/s]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += a[MASS, i] * a[V, i]
    return total


@jit
def momentum_pullback(a, bar, first, last, slope):
    """Adds slope dp/da."""
    for i in range(first + 1, last + 2):
        bar[V, i] += slope * a[MASS, i]
        bar[MASS, i] += slope * a[V, i]


@jit
def contact_energy(a, j):
    """Elastic energy stored in contact j [J]. Not for plastic contacts."""
    d = a[U, j] - a[U, j + 1] + a[REST_OVERLAP, j]
    if a[SCALARS, ELASTIC] == HERTZ:
        return hertz.energy(a[STIFFNESS, j], d)
    return power_law.energy(a[STIFFNESS, j], d, a[SCALARS, EXPONENT])


@jit
def contact_energy_pullback(a, bar, j, slope):
    """Adds slope dE/da."""
    d = _overlap(a, j)
    shape, _ = _elastic(a, j, d)
    force = slope * a[STIFFNESS, j] * shape
    bar[STIFFNESS, j] += slope * shape * d / ((a[SCALARS, EXPONENT] if a[SCALARS, ELASTIC] == POWER else 1.5) + 1.0)
    bar[U, j] += force
    bar[U, j + 1] -= force
    bar[REST_OVERLAP, j] += force


@jit
def energy(a, first, last):
    """Kinetic energy of the grains first..last and half the elastic energy of each contact for each of its grains among them.

    So the energies of neighbouring stretches add up. Walls hold the other half of theirs.
    """
    total = kinetic_energy(a, first, last)
    for j in range(first, last + 2):
        total += (0.5 if j in (first, last + 1) else 1.0) * contact_energy(a, j)
    return total


@jit
def energy_pullback(a, bar, first, last, slope):
    """Adds slope dE/da."""
    kinetic_energy_pullback(a, bar, first, last, slope)
    for j in range(first, last + 2):
        contact_energy_pullback(a, bar, j, (0.5 if j in (first, last + 1) else 1.0) * slope)


# -- roots of the energy ------------------------------------------------------------------------------------------------


@inlined
def _lengths(a, j):
    """Return s and s0 of contact j, 0 for a gap."""
    d = kernels.overlap(a, U, j)
    return math.sqrt(d) if d > SMALLEST_OVERLAP else 0.0, math.sqrt(max(a[REST_OVERLAP, j], 0.0))


@inlined
def _quotient(s, s0):
    """Return Q."""
    return s * s * (0.4 * s + 0.8 * s0) + s0 * s0 * (1.2 * s + 0.6 * s0)


@inlined
def energy_root(a, j):
    """Return q of contact j [J^0.5]."""
    s, s0 = _lengths(a, j)
    return math.sqrt(a[STIFFNESS, j] * _quotient(s, s0)) * (s - s0)


@jit
def energy_root_pullback(a, bar, j, slope):
    """Add slope dq_j/da to bar."""
    s, s0 = _lengths(a, j)
    quotient = _quotient(s, s0)
    if quotient <= 0.0 or a[STIFFNESS, j] <= 0.0:
        return
    root = math.sqrt(a[STIFFNESS, j] / quotient)
    bar[STIFFNESS, j] += slope * 0.5 * root * quotient * (s - s0) / a[STIFFNESS, j]
    along = slope * 0.5 * root * (s * s + s * s0 + s0 * s0) if s > 0.0 else 0.0
    bar[U, j] += along
    bar[U, j + 1] -= along
    # A longer overlap at rest makes the whole overlap longer, and is what the energy counts from.
    bar[REST_OVERLAP, j] += along - slope * 0.75 * root * s0 * (s + s0)


@jit
def energy_between(a, first, last):
    """Energy above that at rest of the columns first..last and of the contacts from `first` on up to `last` [J]."""
    energy = 0.0
    for i in range(first, last + 1):
        energy += 0.5 * a[MASS, i] * (a[V, i] * a[V, i])
    for j in range(first, last + 1):
        q = energy_root(a, j)
        energy += q * q
    return energy


@jit
def energy_between_pullback(a, bar, first, last, slope):
    """Add slope denergy/da of `energy_between` to bar."""
    for i in range(first, last + 1):
        bar[V, i] += slope * a[MASS, i] * a[V, i]
        bar[MASS, i] += slope * 0.5 * (a[V, i] * a[V, i])
    for j in range(first, last + 1):
        energy_root_pullback(a, bar, j, 2.0 * slope * energy_root(a, j))
