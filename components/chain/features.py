"""Features for objectives, each with its derivative: jitted functions for a `note` and the `pull` that belongs to it.

A feature is read off the table (`table.py`): grain i, from 0, is column i + 1; contact j lies between columns j and j + 1, so
that contacts 0 and n are the walls'. `pull_x(a, bar, ..., slope)` adds slope times the derivative of `x(a, ...)` to `bar`.

A peak over time is not smooth: it is replaced by the p-norm over the control steps, f0 (sum_t (f_t / f0)^p)^(1/p), p even. It
lies above the largest |f_t|, by a factor of m^(1/p) at most for m equal peaks; `peak_feature` is its summand, `peak_value` the
root.
"""

from __future__ import annotations

from math import sqrt

from ..support.jit import inlined, jit
from ..support.powers import power
from .laws import dispatch, hertz
from .laws import power as power_law
from .table import (
    CONTACT,
    DISSIPATION,
    ELASTIC,
    EXPONENT,
    HERTZ,
    MASS,
    NONE,
    POWER,
    REST,
    SCALARS,
    SMALLEST_OVERLAP,
    STIFFNESS,
    VISCOUS,
    U,
    V,
)


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
def pull_peak_feature(f, scale, p):
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
    d = a[U, j] - a[U, j + 1] + a[REST, j]
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
def contact_force(a, j):
    """Compressive force in contact j, its dissipation included, never a pull [N]. Not for plastic contacts."""
    d = _overlap(a, j)
    f = a[STIFFNESS, j] * _elastic(a, j, d)[0]
    if a[SCALARS, DISSIPATION] != NONE:
        f += dispatch.coefficient(int(a[SCALARS, DISSIPATION]), a, j, d) * (a[V, j] - a[V, j + 1])
    return 0.0 if f < 0.0 else f


@jit
def pull_contact_force(a, bar, j, slope):
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
    bar[REST, j] += slope * steepness


@jit
def kinetic_energy(a, first, last):
    """Of the grains first..last, from 0 and both included [J]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += 0.5 * a[MASS, i] * a[V, i] * a[V, i]
    return total


@jit
def pull_kinetic_energy(a, bar, first, last, slope):
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
def pull_momentum(a, bar, first, last, slope):
    """Adds slope dp/da."""
    for i in range(first + 1, last + 2):
        bar[V, i] += slope * a[MASS, i]
        bar[MASS, i] += slope * a[V, i]


@jit
def contact_energy(a, j):
    """Elastic energy stored in contact j [J]. Not for plastic contacts."""
    d = a[U, j] - a[U, j + 1] + a[REST, j]
    if a[SCALARS, ELASTIC] == HERTZ:
        return hertz.energy(a[STIFFNESS, j], d)
    return power_law.energy(a[STIFFNESS, j], d, a[SCALARS, EXPONENT])


@jit
def pull_contact_energy(a, bar, j, slope):
    """Adds slope dE/da."""
    d = _overlap(a, j)
    shape, _ = _elastic(a, j, d)
    force = slope * a[STIFFNESS, j] * shape
    bar[STIFFNESS, j] += slope * shape * d / ((a[SCALARS, EXPONENT] if a[SCALARS, ELASTIC] == POWER else 1.5) + 1.0)
    bar[U, j] += force
    bar[U, j + 1] -= force
    bar[REST, j] += force


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
def pull_energy(a, bar, first, last, slope):
    """Adds slope dE/da."""
    pull_kinetic_energy(a, bar, first, last, slope)
    for j in range(first, last + 2):
        pull_contact_energy(a, bar, j, (0.5 if j in (first, last + 1) else 1.0) * slope)
