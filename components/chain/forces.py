"""Equations of motion: contact forces, the drive of the ends, and the tallies (sums since the reset) of work and impulse.

m_i u_i'' = F_i - F_(i+1) + m_i g, with F_i the force in the contact left of grain i. Symbols: u displacement, v velocity, d
overlap, w inverse mass, h step, e fraction of a step after the tick.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import internal, internal_inlined
from .drive import polynomial_integral, polynomial_value
from .laws.functions import begin_history, damping, energy, force, has_history, update_history
from .layout import (
    BESIDE_GRAINS,
    IMPULSE_LEFT,
    IMPULSE_RIGHT,
    INVERSE_MASS,
    LOST,
    REST_OVERLAP,
    SMALLEST_OVERLAP,
    TALLY,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)  # fmt: skip

# Number of partial sums: many in long chains, where they vectorise; few in short ones, where joining them would cost more.
_FEW_LANES, _MANY_LANES, _MANY_GRAINS = 8, 256, 2048


@internal
def copy_array(source, target):
    """Copy numbers; with a slice assignment numba would also compile its error handling."""
    for i in range(len(source)):
        target[i] = source[i]


@internal
def fill_array(target, number):
    """Set all entries to a number."""
    for i in range(len(target)):
        target[i] = number


@internal_inlined
def displacements(chain):
    """Return the part of row U with the displacements of the grains and of the walls, a view."""
    return chain.rows[U, : chain.settings.grains + 2]


@internal_inlined
def velocities_and_tallies(chain):
    """Return the velocities of the grains and the walls, followed by the five tallies."""
    return chain.rows[V, : chain.settings.grains + BESIDE_GRAINS]


# -- contacts -----------------------------------------------------------------------------------------------------------


@internal_inlined
def positive_part(d):
    """Return the overlap of a closed contact, or 0 for an open one. NaN stays NaN."""
    return 0.0 if d < SMALLEST_OVERLAP else d


@internal_inlined
def contact_overlap(chain, u, j):
    """Return the overlap of contact j at the displacements u, 0 if it is open."""
    return positive_part(u[j] - u[j + 1] + chain.rows[REST_OVERLAP, j])


@internal_inlined
def elastic_force(chain, u, j):
    """Return the elastic force in contact j at the displacements u."""
    return force(chain.law, j, contact_overlap(chain, u, j))


@internal_inlined
def contact_force(chain, u, v, j):
    """Return the force in contact j with dissipation, never attractive, and the dissipated power."""
    d = contact_overlap(chain, u, j)
    elastic, speed = force(chain.law, j, d), v[j] - v[j + 1]
    total = elastic + (damping(chain.law, j, d) if d > 0.0 else 0.0) * speed
    total = 0.0 if total < 0.0 else total
    return total, (total - elastic) * speed


@internal_inlined
def contact_forces(chain, out):
    """Write the force in each contact, dissipation included."""
    for j in range(len(out)):
        out[j], _ = contact_force(chain, chain.rows[U], chain.rows[V], j)


@internal
def initialise_histories(chain):
    """Write the histories of contacts that have never been loaded."""
    for j in range(chain.settings.grains + 1):
        begin_history(chain.law, j)


@internal_inlined
def update_histories(chain):
    """Update the histories of the contacts after a step, and tally the dissipated energy."""
    if has_history(chain.law):
        for j in range(chain.settings.grains + 1):
            chain.rows[LOST, j] += update_history(chain.law, j, contact_overlap(chain, chain.rows[U], j))


@internal
def update_peaks(u, rest_overlap, limit, peak):
    """Update the largest overlaps; return whether an overlap exceeds its limit."""
    left, right, passed = u[:-1], u[1:], False
    for j in range(len(peak)):
        d, p = positive_part(left[j] - right[j] + rest_overlap[j]), peak[j]
        peak[j] = d if d > p else p
        passed |= not (d <= limit[j])
    return passed


@internal
def is_too_fast(v, limit):
    """Return whether a velocity exceeds a limit or is NaN."""
    found = False
    for i in range(len(v)):
        found |= not (abs(v[i]) <= limit)
    return found


# -- ends ---------------------------------------------------------------------------------------------------------------


@internal_inlined
def left_end_force(chain, drive, e):
    """Return the force on a free left end, positive to the right; 0 on other ends."""
    end = chain.settings.left
    return end.static_force + polynomial_value(drive.left, e) if end.is_free else 0.0


@internal_inlined
def right_end_force(chain, drive, e):
    """Return the force on a free right end, positive to the right; 0 on other ends."""
    end = chain.settings.right
    return polynomial_value(drive.right, e) - end.static_force if end.is_free else 0.0


@internal_inlined
def place_pistons(chain, u, drive, positions, e):
    """Move prescribed grains to their positions at e: `positions` at the tick, plus the exact integral of the drive."""
    h = chain.settings.step
    if chain.settings.left.is_piston:
        u[1] = positions[0] + h * polynomial_integral(drive.left, e)
    if chain.settings.right.is_piston:
        u[chain.settings.grains] = positions[1] + h * polynomial_integral(drive.right, e)


@internal_inlined
def set_piston_velocities(chain, v, drive, e):
    """Set the velocities of prescribed grains to the values of the drive at e."""
    if chain.settings.left.is_piston:
        v[1] = polynomial_value(drive.left, e)
    if chain.settings.right.is_piston:
        v[chain.settings.grains] = polynomial_value(drive.right, e)


@internal_inlined
def end_values(chain, x):
    """Return the entries of the first and the last grain in a row x of the table."""
    return x[1], x[chain.settings.grains]


@internal_inlined
def tally_pistons(chain, old_velocities):
    """Tally the work and impulse that changed prescribed grains from their velocities `old_velocities` to the present ones."""
    left, right, tally = chain.settings.left, chain.settings.right, chain.rows[TALLY]
    first, last = end_values(chain, chain.rows[V])
    if left.is_piston:
        add_compensated(tally, WORK_LEFT, 0.5 * left.mass * (first - old_velocities[0]) * (first + old_velocities[0]))
        add_compensated(tally, IMPULSE_LEFT, left.mass * (first - old_velocities[0]))
    if right.is_piston:
        add_compensated(tally, WORK_RIGHT, 0.5 * right.mass * (last - old_velocities[1]) * (last + old_velocities[1]))
        add_compensated(tally, IMPULSE_RIGHT, right.mass * (last - old_velocities[1]))


@internal_inlined
def compensated_sum(total, compensation, x):
    """Add x to a sum by Kahan's summation; return the new sum and the rounding error in it, the new compensation."""
    y = x - compensation
    t = total + y
    return t, (t - total) - y


@internal_inlined
def add_compensated(tally, place, x):
    """Add x to the compensated sum in two adjacent entries of the tally."""
    tally[place], tally[place + 1] = compensated_sum(tally[place], tally[place + 1], x)


# -- explicit integrators -----------------------------------------------------------------------------------------------


@internal
def accelerations(chain, u, v, drive, e, out):
    """Write dv/dt of the grains at e to `out`, then the powers of the ends, the forces of the ends, the dissipated power."""
    n, w, gravity = chain.settings.grains, chain.rows[INVERSE_MASS], chain.settings.gravity
    left, right = left_end_force(chain, drive, e), right_end_force(chain, drive, e)
    first, loss = contact_force(chain, u, v, 0)
    second, _ = contact_force(chain, u, v, 1)
    before_last, _ = contact_force(chain, u, v, n - 1)
    f = first + left
    for i in range(1, n):
        g, lost = contact_force(chain, u, v, i)
        out[i] = w[i] * (f - g) + gravity
        loss += lost
        f = g
    last, lost = contact_force(chain, u, v, n)
    out[n] = w[n] * (f - (last - right)) + gravity
    powers, thrusts = out[n + 2 : n + 4], out[n + 4 : n + 6]
    powers[0], thrusts[0] = left * v[1], first + left
    powers[1], thrusts[1] = right * v[n], right - last
    if chain.settings.left.is_piston:
        powers[0], thrusts[0] = second * polynomial_value(drive.left, e), second
    if chain.settings.right.is_piston:
        powers[1], thrusts[1] = -before_last * polynomial_value(drive.right, e), -before_last
    out[n + 6] = loss + lost


# -- sums ---------------------------------------------------------------------------------------------------------------


@internal
def energies(chain, mass):
    """Return kinetic energy, elastic energy and momentum, as compensated partial sums (lanes) that are added in order.

    The lanes fix the order of summation and let the sums vectorise. `mass` includes prescribed grains, shape (n,) [kg].
    """
    n = len(mass)
    width = _FEW_LANES if n < _MANY_GRAINS else _MANY_LANES
    lanes = np.zeros((6, width))
    for j in range(0, n + 1, width):
        _add_potential_energies(chain, lanes[2], lanes[3], j, min(width, n + 1 - j))
    for i in range(0, n, width):
        _add_kinetic_energies(chain.rows[V, i + 1 :], mass[i:], lanes, min(width, n - i))
    return _lane_sum(lanes[0], lanes[1]), _lane_sum(lanes[2], lanes[3]), _lane_sum(lanes[4], lanes[5])


@internal
def _lane_sum(totals, compensations):
    total, compensation = 0.0, 0.0
    for lane in range(len(totals)):
        total, compensation = compensated_sum(total, compensation, totals[lane])
        total, compensation = compensated_sum(total, compensation, -compensations[lane])
    return total


@internal
def _add_potential_energies(chain, totals, compensations, begin, count):
    for lane in range(count):
        stored = energy(chain.law, begin + lane, contact_overlap(chain, chain.rows[U], begin + lane))
        totals[lane], compensations[lane] = compensated_sum(totals[lane], compensations[lane], stored)


@internal
def _add_kinetic_energies(v, mass, lanes, count):
    for lane in range(count):
        kinetic, momentum = 0.5 * mass[lane] * (v[lane] * v[lane]), mass[lane] * v[lane]
        lanes[0, lane], lanes[1, lane] = compensated_sum(lanes[0, lane], lanes[1, lane], kinetic)
        lanes[4, lane], lanes[5, lane] = compensated_sum(lanes[4, lane], lanes[5, lane], momentum)
