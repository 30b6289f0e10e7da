"""Quantities of a chain for jitted code, with their pullbacks, as used by sensors, tasks and objectives.

A quantity is a function of a `ChainState`, such as `Chain.state`: grain i, from 0, has the column i + 1; contact j lies between
columns j and j + 1, so that contacts 0 and n belong to the walls. `x_pullback(chain, adjoint, ..., slope)` adds slope times the
derivative of `x(chain, ...)` to `adjoint`, also a `ChainState`. Forces are bitwise equal to the component's outputs.

A peak over time is not smooth. It is replaced by the p-norm over the control steps, f0 (sum_t (f_t / f0)^p)^(1/p), p even. The
norm exceeds the largest |f_t| by a factor of at most m^(1/p) for m equal peaks. `peak_feature` is its summand, `peak_value`
the root.

Roots of the energy measure distances between states, in which every motion is weighted by its energy. A contact with the energy
e above its energy at rest has the root q = +-sqrt(e), negative if it is less compressed than at rest. The distance of two
states is sum_i m_i (v_i - v'_i)^2 / 2 + sum_j (q_j - q'_j)^2, i.e. the energy itself if the second state is at rest. A gap
stores no energy. The law must have an `energy_root`.
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
    """Return the compressive force in contact j, with dissipation, never attractive; 0 without a contact [N]."""
    force, _ = forces.contact_force(chain, chain.rows[U], chain.rows[V], j)
    return force


@inlined
def _contact_overlap(chain, j):
    return forces.contact_overlap(chain, chain.rows[U], j)


@inlined
def _add_overlap(adjoint, j, slope):
    """Add slope times the derivative with respect to the overlap of contact j."""
    adjoint.rows[U, j] += slope
    adjoint.rows[U, j + 1] -= slope
    adjoint.rows[REST_OVERLAP, j] += slope


@jit
def contact_force_pullback(chain, adjoint, j, slope):
    """Add slope times the derivative of `contact_force` to `adjoint`."""
    d, by_overlap = _contact_overlap(chain, j), 0.0
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
    return law.energy(chain.law, j, _contact_overlap(chain, j))


@jit
def contact_energy_pullback(chain, adjoint, j, slope):
    """Add slope times the derivative of `contact_energy` to `adjoint`."""
    d = _contact_overlap(chain, j)
    law.energy_pullback(chain.law, adjoint.law, j, d, slope)
    _add_overlap(adjoint, j, slope * law.force(chain.law, j, d))


@jit
def energy_root(chain, j):
    """Return q = +-sqrt(e), e the energy of contact j above that at rest; negative if less compressed than at rest [J^0.5]."""
    return law.energy_root(chain.law, j, _contact_overlap(chain, j), chain.rows[REST_OVERLAP, j])


@jit
def energy_root_pullback(chain, adjoint, j, slope):
    """Add slope times the derivative of `energy_root` to `adjoint`."""
    d, rest = _contact_overlap(chain, j), chain.rows[REST_OVERLAP, j]
    by_overlap, by_rest = law.energy_root_pullback(chain.law, adjoint.law, j, d, rest, slope)
    _add_overlap(adjoint, j, by_overlap)
    adjoint.rows[REST_OVERLAP, j] += by_rest


@jit
def input_work(chain):
    """Return the work of inputs and boundaries since the reset, equal to the component's `input_work`."""
    tally, behind = chain.rows[TALLY], chain.settings.grains + 2
    return (tally[WORK_LEFT] + tally[WORK_RIGHT]) + chain.rows[V, behind] + chain.rows[V, behind + 1]


# -- pullbacks ----------------------------------------------------------------------------------------------------------


whole_power = jit(integer_power)


@jit
def peak_feature(f, scale, p):
    """Return (f / scale)^p; `peak_value` turns its sum over the control steps into a smooth maximum."""
    return whole_power(f / scale, p)


@jit
def peak_feature_pullback(f, scale, p):
    """Return the derivative of `peak_feature` with respect to f."""
    return p * whole_power(f / scale, p - 1) / scale


@jit
def peak_value(total, scale, p):
    """Return the smooth maximum scale total^(1/p) and its derivative with respect to the total; (0, 0) for a zero total."""
    if not total > 1e-300:  # true for NaN too, which must not be hidden
        return scale * total, 0.0
    root = scale * power(total, 1.0 / p)
    return root, root / (p * total)


@jit
def kinetic_energy(chain, first, last):
    """Return the kinetic energy of the grains first..last, counted from 0 [J]; a prescribed grain of a piston has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += 0.5 * chain.rows[MASS, i] * (chain.rows[V, i] * chain.rows[V, i])
    return total


@jit
def kinetic_energy_pullback(chain, adjoint, first, last, slope):
    """Add slope times the derivative of `kinetic_energy` to `adjoint`."""
    for i in range(first + 1, last + 2):
        adjoint.rows[V, i] += slope * chain.rows[MASS, i] * chain.rows[V, i]
        adjoint.rows[MASS, i] += slope * 0.5 * (chain.rows[V, i] * chain.rows[V, i])


@jit
def momentum(chain, first, last):
    """Return the momentum of the grains first..last, counted from 0 [kg m/s]; a prescribed grain of a piston has none."""
    total = 0.0
    for i in range(first + 1, last + 2):
        total += chain.rows[MASS, i] * chain.rows[V, i]
    return total


@jit
def momentum_pullback(chain, adjoint, first, last, slope):
    """Add slope times the derivative of `momentum` to `adjoint`."""
    for i in range(first + 1, last + 2):
        adjoint.rows[V, i] += slope * chain.rows[MASS, i]
        adjoint.rows[MASS, i] += slope * chain.rows[V, i]


@jit
def energy(chain, first, last):
    """Return the kinetic energy of grains first..last plus half the elastic energy of a contact per grain in this range [J].

    The energies of adjacent ranges thus add up. A wall counts as the other side of its contact.
    """
    total = kinetic_energy(chain, first, last)
    for j in range(first, last + 2):
        total += (0.5 if j in (first, last + 1) else 1.0) * contact_energy(chain, j)
    return total


@jit
def energy_pullback(chain, adjoint, first, last, slope):
    """Add slope times the derivative of `energy` to `adjoint`."""
    kinetic_energy_pullback(chain, adjoint, first, last, slope)
    for j in range(first, last + 2):
        contact_energy_pullback(chain, adjoint, j, (0.5 if j in (first, last + 1) else 1.0) * slope)


# -- roots of the energy ------------------------------------------------------------------------------------------------


@jit
def excess_energy(chain, first, last):
    """Return the energy above the rest state of columns first..last and of contacts first..last [J]."""
    energy = kinetic_energy(chain, first - 1, last - 1)
    for j in range(first, last + 1):
        q = energy_root(chain, j)
        energy += q * q
    return energy


@jit
def excess_energy_pullback(chain, adjoint, first, last, slope):
    """Add slope times the derivative of `excess_energy` to `adjoint`."""
    kinetic_energy_pullback(chain, adjoint, first - 1, last - 1, slope)
    for j in range(first, last + 1):
        energy_root_pullback(chain, adjoint, j, 2.0 * slope * energy_root(chain, j))
