"""The roots of a chain's energy: distances between states in which every motion counts by its energy. Hertz contacts only.

A contact that stores the energy e above that at rest has the root q = +-sqrt(e), negative where it is less pressed than at
rest. Two states differ by sum_i m_i (v_i - v'_i)^2 / 2 + sum_j (q_j - q'_j)^2: the energy itself where the second is at rest.

With s = sqrt(d), d the whole overlap, and s0 that at rest, e = k (s - s0)^2 Q, Q = .4 s^3 + .8 s^2 s0 + 1.2 s s0^2 + .6 s0^3:
no difference of large numbers, whatever the precompression. Without one, q = sqrt(.4 k) d^1.25. A gap stores nothing.
"""

from __future__ import annotations

import math

from ..support.jit import inlined, jit
from .kernels import overlap
from .table import MASS, REST, SMALLEST_OVERLAP, STIFFNESS, U, V


@inlined
def _lengths(a, j):
    """S and s0 of contact j, 0 for a gap."""
    d = overlap(a, U, j)
    return math.sqrt(d) if d > SMALLEST_OVERLAP else 0.0, math.sqrt(max(a[REST, j], 0.0))


@inlined
def _quotient(s, s0):
    """Q."""
    return s * s * (0.4 * s + 0.8 * s0) + s0 * s0 * (1.2 * s + 0.6 * s0)


@inlined
def energy_root(a, j):
    """Q of contact j [J^.5]."""
    s, s0 = _lengths(a, j)
    return math.sqrt(a[STIFFNESS, j] * _quotient(s, s0)) * (s - s0)


@jit
def pull_energy_root(a, bar, j, slope):
    """Bar += slope dq_j/da."""
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
    bar[REST, j] += along - slope * 0.75 * root * s0 * (s + s0)


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
def pull_energy_between(a, bar, first, last, slope):
    """Bar += slope denergy/da of `energy_between`."""
    for i in range(first, last + 1):
        bar[V, i] += slope * a[MASS, i] * a[V, i]
        bar[MASS, i] += slope * 0.5 * (a[V, i] * a[V, i])
    for j in range(first, last + 1):
        pull_energy_root(a, bar, j, 2.0 * slope * energy_root(a, j))
