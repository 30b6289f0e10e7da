"""Quantities of a chain for jitted code, with their pullbacks: what sensors, tasks and objectives read.

A quantity is a function of a `ChainState`, such as `Chain.state`: grain i, from 0, is column i + 1 of its rows; contact j lies
between columns j and j + 1, so that contacts 0 and n are the walls'. `x_pullback(chain, adjoint, ..., slope)` adds slope times
the derivative of `x(chain, ...)` to `adjoint`, a `ChainState` too. Forces have the bits of the component's outputs.

A peak over time is not smooth: it is replaced by the p-norm over the control steps, f0 (sum_t (f_t / f0)^p)^(1/p), p even. It
lies above the largest |f_t|, by a factor of m^(1/p) at most for m equal peaks; `peak_feature` is its summand, `peak_value` the
root.

Roots of the energy measure distances between states in which every motion counts by its energy. A contact that stores the
energy e above that at rest has the root q = +-sqrt(e), negative where it is less pressed than at rest. Two states differ by
sum_i m_i (v_i - v'_i)^2 / 2 + sum_j (q_j - q'_j)^2: the energy itself where the second is at rest. A gap stores nothing. For
laws that have an `energy_root`.
"""

from __future__ import annotations

from ..support.elementary_functions import integer_power
from ..support.jit import inlined, jit
from ..support.powers import power
from . import forces
from .laws import functions as law
from .layout import MASS, REST_OVERLAP, TALLY, WORK_LEFT, WORK_RIGHT, U, V

# -- contacts and ends, and the work of inputs ---------------------------------------------------------------------------


@jit
def contact_force(chain, j):
    """Return the compressive force in contact j, dissipation included, never a pull; 0 where there is no contact [N]."""
    force, _ = forces.contact_force(chain, chain.rows[U], chain.rows[V], j)
    return force


@inlined
def _pressed_overlap(chain, j):
    return forces.pressed_overlap(chain, chain.rows[U], j)


@inlined
def _add_overlap(adjoint, j, slope):
    """Add slope times the derivative by the overlap of contact j."""
    adjoint.rows[U, j] += slope
    adjoint.rows[U, j + 1] -= slope
    adjoint.rows[REST_OVERLAP, j] += slope


@jit
def contact_force_pullback(chain, adjoint, j, slope):
    """Add slope dF/da."""
    d, by_overlap = _pressed_overlap(chain, j), 0.0
    if d > 0.0:
        damping, speed = law.damping(chain.law, j, d), chain.rows[V, j] - chain.rows[V, j + 1]
        if law.force(chain.law, j, d) + damping * speed < 0.0:
            return
        adjoint.rows[V, j] += slope * damping
        adjoint.rows[V, j + 1] -= slope * damping
        by_overlap = law.damping_pullback(chain.law, adjoint.law, j, d, slope * speed)
    _add_overlap(adjoint, j, law.force_pullback(chain.law, adjoint.law, j, d, slope) + by_overlap)


@jit
def contact_energy(chain, j):
    """Return the elastic energy stored in contact j [J]."""
    return law.energy(chain.law, j, _pressed_overlap(chain, j))


@jit
def contact_energy_pullback(chain, adjoint, j, slope):
    """Add slope dE/da."""
    d = _pressed_overlap(chain, j)
    law.energy_pullback(chain.law, adjoint.law, j, d, slope)
    _add_overlap(adjoint, j, slope * law.force(chain.law, j, d))


@jit
def energy_root(chain, j):
    """Return q of contact j [J^0.5]."""
    return law.energy_root(chain.law, j, _pressed_overlap(chain, j), chain.rows[REST_OVERLAP, j])


@jit
def energy_root_pullback(chain, adjoint, j, slope):
    """Add slope dq_j/da."""
    d, rest = _pressed_overlap(chain, j), chain.rows[REST_OVERLAP, j]
    by_overlap, by_rest = law.energy_root_pullback(chain.law, adjoint.law, j, d, rest, slope)
    _add_overlap(adjoint, j, by_overlap)
    adjoint.rows[REST_OVERLAP, j] += by_rest


@jit
def input_work(chain):
    """Return the work done by inputs and boundaries since the reset, as the component's `input_work`."""
    tally, behind = chain.rows[TALLY], chain.settings.grains + 2
    return (tally[WORK_LEFT] + tally[WORK_RIGHT]) + chain.rows[V, behind] + chain.rows[V, behind + 1]


# -- pullbacks ----------------------------------------------------------------------------------------------------------


whole_power = jit(integer_power)


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
def kinetic_energy(chain, first, last):
    """Return the energy of the grains first..last, from 0 and both included [J]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += 0.5 * chain.rows[MASS, i] * (chain.rows[V, i] * chain.rows[V, i])
    return total


@jit
def kinetic_energy_pullback(chain, adjoint, first, last, slope):
    """Add slope dE/da."""
    for i in range(first + 1, last + 2):
        adjoint.rows[V, i] += slope * chain.rows[MASS, i] * chain.rows[V, i]
        adjoint.rows[MASS, i] += slope * 0.5 * (chain.rows[V, i] * chain.rows[V, i])


@jit
def momentum(chain, first, last):
    """Return that of the grains first..last, from 0 and both included [kg m/s]; a piston's own grain has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += chain.rows[MASS, i] * chain.rows[V, i]
    return total


@jit
def momentum_pullback(chain, adjoint, first, last, slope):
    """Add slope dp/da."""
    for i in range(first + 1, last + 2):
        adjoint.rows[V, i] += slope * chain.rows[MASS, i]
        adjoint.rows[MASS, i] += slope * chain.rows[V, i]


@jit
def energy(chain, first, last):
    """Kinetic energy of the grains first..last and half the elastic energy of each contact for each of its grains among them.

    So the energies of neighbouring stretches add up. Walls hold the other half of theirs.
    """
    total = kinetic_energy(chain, first, last)
    for j in range(first, last + 2):
        total += (0.5 if j in (first, last + 1) else 1.0) * contact_energy(chain, j)
    return total


@jit
def energy_pullback(chain, adjoint, first, last, slope):
    """Add slope dE/da."""
    kinetic_energy_pullback(chain, adjoint, first, last, slope)
    for j in range(first, last + 2):
        contact_energy_pullback(chain, adjoint, j, (0.5 if j in (first, last + 1) else 1.0) * slope)


# -- roots of the energy ------------------------------------------------------------------------------------------------


@jit
def energy_between(chain, first, last):
    """Energy above that at rest of the columns first..last and of the contacts from `first` on up to `last` [J]."""
    energy = kinetic_energy(chain, first - 1, last - 1)
    for j in range(first, last + 1):
        q = energy_root(chain, j)
        energy += q * q
    return energy


@jit
def energy_between_pullback(chain, adjoint, first, last, slope):
    """Add slope denergy/da of `energy_between` to adjoint."""
    kinetic_energy_pullback(chain, adjoint, first - 1, last - 1, slope)
    for j in range(first, last + 1):
        energy_root_pullback(chain, adjoint, j, 2.0 * slope * energy_root(chain, j))
