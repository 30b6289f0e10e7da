"""The dissipative flow: only dissipative forces act, at constant displacements, pair by pair and in closed form.

In a contact F = max(c w, -F_e) acts in addition to the elastic force F_e. The approach speed w decays as exp(-c s t), with s
the sum of the inverse masses. Over a time t the impulse is the larger of G w and -F_e t, with s G = 1 - 1 / (1 + x + x^2/2) and
x = c s t. It is second order, never exceeds the impulse that stops the approach however large c is, and conserves momentum.
Even contacts act for half the step, odd ones for the whole step, and the even ones again: the sequence is symmetric and thus
second order. T. Shardlow, SIAM J. Sci. Comput. 24 (2003) 1267, splits dissipative particle dynamics in this way.
A dashpot whose contact closes within the step acts from then on (`acting_time`).
"""

from __future__ import annotations

from ...support.jit import internal, internal_inlined
from .. import forces
from ..laws.functions import damping, force, has_force_jump
from ..layout import (
    DISSIPATION,
    IMPULSE_LEFT,
    IMPULSE_RIGHT,
    INVERSE_MASS,
    LOST,
    MASS,
    REST_OVERLAP,
    SMALLEST_OVERLAP,
    TALLY,
    WORK_LEFT,
    WORK_RIGHT,
    V,
)  # fmt: skip

# A contact that closes exactly between two steps (likely with round numbers) counts only in the second step.
_EDGE = 1e-3


@internal_inlined
def is_closing(d, w, h):
    """Return whether a contact closes within a step h; d is its mid-step overlap, w its approach speed."""
    reach = 0.5 * h * w
    return reach > SMALLEST_OVERLAP and -(1.0 - _EDGE) * reach < d <= (1.0 + _EDGE) * reach


@internal_inlined
def acting_time(law, d, w, h):
    """Return the fraction of a step in which a contact acts; a contact whose force jumps acts from its closing on.

    Otherwise the impulse of the dashpot would jump when the closing moves from one step to the next. The order would be 1 at
    closing contacts, and gradients of a run would be those between two jumps, which are wrong for any step.
    """
    if not has_force_jump(law):
        return h
    whole = h if d >= SMALLEST_OVERLAP else 0.0
    return 0.5 * h + d / w if is_closing(d, w, h) else whole


@internal_inlined
def sweep_fraction(j):
    """Return the duration of a half sweep for contact j as a fraction of the step: 1/2 for even j, 1 for odd j."""
    return 0.5 + 0.5 * (j % 2)


@internal
def prepare_impulses(chain, u):
    """Write for each contact G, the impulse per approach speed, and -F_e t, the least impulse without attraction."""
    v, w, h = chain.rows[V], chain.rows[INVERSE_MASS], chain.settings.step
    per_speed, least = chain.rows[DISSIPATION], chain.rows[DISSIPATION + 1]
    for j in range(chain.settings.grains + 1):
        middle = u[j] - u[j + 1] + chain.rows[REST_OVERLAP, j]
        d = forces.positive_part(middle)
        time = acting_time(chain.law, middle, v[j] - v[j + 1], h) * sweep_fraction(j)
        c = damping(chain.law, j, d) * time
        half = 0.5 * c * (w[j] + w[j + 1])
        per_speed[j] = c * (1.0 + half) / (1.0 + 2.0 * half * (1.0 + half))
        least[j] = -force(chain.law, j, d) * time


@internal_inlined
def contact_impulse(rows, j):
    """Return the dissipative impulse in contact j: G times the approach speed, or -F_e t if larger (see `prepare_impulses`)."""
    free, least = rows[DISSIPATION, j] * (rows[V, j] - rows[V, j + 1]), rows[DISSIPATION + 1, j]
    return free if free > least else least


@internal
def apply_half_sweep(chain, parity):
    """Apply the impulses of all contacts of one parity, no two of which share a grain."""
    v, w = chain.rows[V], chain.rows[INVERSE_MASS]
    for j in range(parity, chain.settings.grains + 1, 2):
        given = contact_impulse(chain.rows, j)
        v[j] -= w[j] * given
        v[j + 1] += w[j + 1] * given


@internal
def apply_dissipation(chain, u):
    """Apply the dissipative forces for a step at the displacements u; tally dissipation, and impulse and work of the ends."""
    a, n = chain.rows, chain.settings.grains
    v, old, tally = a[V], a[DISSIPATION + 2], a[TALLY]
    left, right = 1 if chain.settings.left.is_piston else 0, n - 1 if chain.settings.right.is_piston else n
    prepare_impulses(chain, u)
    forces.copy_array(v[: n + 1], old)
    impulses, works = (0.0, 0.0), (0.0, 0.0)
    for sweep in range(3):
        parity = sweep % 2
        first = contact_impulse(a, left) if left % 2 == parity else 0.0
        last = contact_impulse(a, right) if right % 2 == parity else 0.0
        impulses = impulses[0] + first, impulses[1] - last
        works = works[0] + first * v[left], works[1] - last * v[right + 1]
        apply_half_sweep(chain, parity)
    for i in range(1, n + 1):
        a[LOST, i] += 0.5 * a[MASS, i] * ((old[i] - v[i]) * (old[i] + v[i]))
    # Pistons have also done work against the contacts.
    a[LOST, 0] += works[0] + works[1]
    forces.add_compensated(tally, IMPULSE_LEFT, impulses[0])
    forces.add_compensated(tally, IMPULSE_RIGHT, impulses[1])
    forces.add_compensated(tally, WORK_LEFT, works[0])
    forces.add_compensated(tally, WORK_RIGHT, works[1])
