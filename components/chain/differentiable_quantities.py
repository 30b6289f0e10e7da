"""Quantities of a chain's table for jitted code, with their pullbacks: what sensors, tasks and objectives read.

A quantity is read off the table (`layout.py`): grain i, from 0, is column i + 1; contact j lies between columns j and j + 1, so
that contacts 0 and n are the walls'. `x_pullback(a, adjoint, ..., slope)` adds slope times the derivative of `x(a, ...)` to
`adjoint`. Forces have the bits of the component's outputs.

A peak over time is not smooth: it is replaced by the p-norm over the control steps, f0 (sum_t (f_t / f0)^p)^(1/p), p even. It
lies above the largest |f_t|, by a factor of m^(1/p) at most for m equal peaks; `peak_feature` is its summand, `peak_value` the
root.

Roots of the energy measure distances between states in which every motion counts by its energy. A contact that stores the
energy e above that at rest has the root q = +-sqrt(e), negative where it is less pressed than at rest. Two states differ by
sum_i m_i (v_i - v'_i)^2 / 2 + sum_j (q_j - q'_j)^2: the energy itself where the second is at rest. A gap stores nothing. For
laws that have an `energy_root`.

What depends on the contact law works for a chosen one only: `Chain.specialise` makes such a kernel of any that uses these, and
environments and gradients call it by themselves.
"""

from __future__ import annotations

from ..support.jit import inlined, jit
from ..support.powers import power
from . import equations_of_motion as equations
from .laws import placeholders as law
from .laws.placeholders import DISSIPATES
from .layout import GRAINS, MASS, REST_OVERLAP, SCALARS, STIFFNESS, TALLY, WORK_LEFT, WORK_RIGHT, U, V

# -- contacts and ends, and the work of inputs ---------------------------------------------------------------------------


@jit
def contact_force(a, j):
    """Return the compressive force in contact j, dissipation included, never a pull; 0 where there is no contact [N]."""
    return equations.contact_force(a, U, V, j)


@inlined
def _pressed_overlap(a, j):
    return equations.pressed(a[U, j] - a[U, j + 1] + a[REST_OVERLAP, j])


@inlined
def _add_overlap(adjoint, j, slope):
    """Add slope times the derivative by the overlap of contact j."""
    adjoint[U, j] += slope
    adjoint[U, j + 1] -= slope
    adjoint[REST_OVERLAP, j] += slope


@jit
def contact_force_pullback(a, adjoint, j, slope):
    """Add slope dF/da."""
    d = _pressed_overlap(a, j)
    by_overlap = 0.0
    if DISSIPATES:
        speed = a[V, j] - a[V, j + 1]
        coefficient = law.coefficient(a, j, d) if d > 0.0 else 0.0
        if law.force(a, j, d) + coefficient * speed < 0.0:
            return
        adjoint[V, j] += slope * coefficient
        adjoint[V, j + 1] -= slope * coefficient
        if d > 0.0:
            by_overlap = law.coefficient_pullback(a, adjoint, j, d, slope * speed)
    _, stiffness, by_stiffness = law.force_slopes(a, j, d)
    adjoint[STIFFNESS, j] += slope * by_stiffness
    _add_overlap(adjoint, j, slope * stiffness + by_overlap)


@jit
def contact_energy(a, j):
    """Return the elastic energy stored in contact j [J]."""
    return law.energy(a, j, _pressed_overlap(a, j))


@jit
def contact_energy_pullback(a, adjoint, j, slope):
    """Add slope dE/da."""
    d = _pressed_overlap(a, j)
    law.energy_pullback(a, adjoint, j, d, slope)
    _add_overlap(adjoint, j, slope * law.force(a, j, d))


@jit
def energy_root(a, j):
    """Return q of contact j [J^0.5]."""
    return law.energy_root(a, j, _pressed_overlap(a, j), a[REST_OVERLAP, j])


@jit
def energy_root_pullback(a, adjoint, j, slope):
    """Add slope dq_j/da."""
    by_overlap, by_rest = law.energy_root_pullback(a, adjoint, j, _pressed_overlap(a, j), a[REST_OVERLAP, j], slope)
    _add_overlap(adjoint, j, by_overlap)
    adjoint[REST_OVERLAP, j] += by_rest


@jit
def grain_force(a, i):
    """Return the reading of a sensor inside the grain of column i: the mean of the forces in its two contacts."""
    return 0.5 * (contact_force(a, i - 1) + contact_force(a, i))


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
    """Return the derivative of `peak_feature` by f."""
    return p * whole_power(f / scale, p - 1) / scale


@jit
def peak_value(total, scale, p):
    """Return the smooth maximum scale total^(1/p), and its derivative by the total; (0, 0) where nothing was felt."""
    if not total > 1e-300:  # NaN too, which must not be hidden
        return scale * total, 0.0
    root = scale * power(total, 1.0 / p)
    return root, root / (p * total)


@jit
def kinetic_energy(a, first, last):
    """Return the energy of the grains first..last, from 0 and both included [J]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += 0.5 * a[MASS, i] * a[V, i] * a[V, i]
    return total


@jit
def kinetic_energy_pullback(a, adjoint, first, last, slope):
    """Add slope dE/da."""
    for i in range(first + 1, last + 2):
        adjoint[V, i] += slope * a[MASS, i] * a[V, i]
        adjoint[MASS, i] += slope * 0.5 * a[V, i] * a[V, i]


@jit
def momentum(a, first, last):
    """Return that of the grains first..last, from 0 and both included [kg m/s]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += a[MASS, i] * a[V, i]
    return total


@jit
def momentum_pullback(a, adjoint, first, last, slope):
    """Add slope dp/da."""
    for i in range(first + 1, last + 2):
        adjoint[V, i] += slope * a[MASS, i]
        adjoint[MASS, i] += slope * a[V, i]


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
def energy_pullback(a, adjoint, first, last, slope):
    """Add slope dE/da."""
    kinetic_energy_pullback(a, adjoint, first, last, slope)
    for j in range(first, last + 2):
        contact_energy_pullback(a, adjoint, j, (0.5 if j in (first, last + 1) else 1.0) * slope)


# -- roots of the energy ------------------------------------------------------------------------------------------------


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
def energy_between_pullback(a, adjoint, first, last, slope):
    """Add slope denergy/da of `energy_between` to adjoint."""
    for i in range(first, last + 1):
        adjoint[V, i] += slope * a[MASS, i] * a[V, i]
        adjoint[MASS, i] += slope * 0.5 * (a[V, i] * a[V, i])
    for j in range(first, last + 1):
        energy_root_pullback(a, adjoint, j, 2.0 * slope * energy_root(a, j))
