"""Symplectic compositions of drifts (u += c h v) and kicks (v += b h F/m): PEFRL and leapfrog.

PEFRL: I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188, eq. (20): order 4, four forces per
step. Leapfrog (position Verlet): order 2, one force per step. The dissipative flow over the whole step is inserted in the
middle: the composition stays symmetric, and is thus of second order.

Work and impulse of the ends are advanced by the exact flow of each kick, so they have the order of the scheme.
"""

from __future__ import annotations

from typing import NamedTuple

from ...support.jit import internal, internal_inlined
from .. import forces
from ..drive import polynomial_value
from ..laws.functions import force
from ..layout import (
    IMPULSE_LEFT,
    IMPULSE_RIGHT,
    INVERSE_MASS,
    LIMIT,
    OTHER_U,
    PEAK,
    REST_OVERLAP,
    TALLY,
    WORK_LEFT,
    WORK_RIGHT,
    U,
    V,
)  # fmt: skip
from .dissipative_step import apply_dissipation
from .scheme import advance_tick


class Composition(NamedTuple):
    """Durations of the alternating drifts and kicks and times of the kicks, as fractions of the step."""

    drifts: tuple[float, ...]
    kicks: tuple[float, ...]
    kick_times: tuple[float, ...]


class DampedComposition(NamedTuple):
    """A `Composition` with the dissipative flow as the middle kick."""

    drifts: tuple[float, ...]
    kicks: tuple[float, ...]
    kick_times: tuple[float, ...]


_XI, _LAMBDA, _CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
_MIDDLE = 1.0 - 2.0 * (_CHI + _XI)
_OUTER_KICK = (1.0 - 2.0 * _LAMBDA) / 2.0
PEFRL = Composition(
    (_XI, _CHI, _MIDDLE, _CHI, _XI),
    (_OUTER_KICK, _LAMBDA, _LAMBDA, _OUTER_KICK),
    (_XI, _XI + _CHI, 1.0 - (_XI + _CHI), 1.0 - _XI),
)
LEAPFROG = Composition((0.5, 0.5), (1.0,), (0.5,))
DAMPED_PEFRL = DampedComposition(
    (_XI, _CHI, 0.5 * _MIDDLE, 0.5 * _MIDDLE, _CHI, _XI),
    (_OUTER_KICK, _LAMBDA, 0.0, _LAMBDA, _OUTER_KICK),
    (_XI, _XI + _CHI, 0.5, 1.0 - (_XI + _CHI), 1.0 - _XI),
)
DAMPED_LEAPFROG = DampedComposition((0.5, 0.0, 0.0, 0.5), (0.5, 0.0, 0.5), (0.5, 0.5, 0.5))


class EndForces(NamedTuple):
    """Forces in the outermost contacts 0, 1, n - 1 and n; on free ends, external forces replace the first and the last."""

    first: float
    second: float
    before_last: float
    last: float


@advance_tick.register(Composition)
def composed_tick(scheme, chain, drive, tick, tape):
    """Advance a tick by drifts and kicks; record the displacements at each kick if the tape has rows."""
    h, a, n = chain.settings.step, chain.rows, chain.settings.grains
    u, next_u, v = a[U, : n + 2], a[OTHER_U, : n + 2], a[V, : n + 1]
    base_positions, before = forces.end_values(chain, u), forces.end_values(chain, v)
    drift(u[1:-1], v[1:], scheme.drifts[0] * h)
    forces.place_pistons(chain, u, drive, base_positions, scheme.drifts[0])
    passed_limit = forces.update_peaks(u, a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])
    for s in range(len(scheme.kicks)):
        if len(tape) > 0:
            forces.copy_array(u, tape[s])
        kick(chain, u, next_u, drive, (scheme.kick_times[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h))
        forces.place_pistons(chain, next_u, drive, base_positions, scheme.kick_times[s] + scheme.drifts[s + 1])
        u, next_u = next_u, u
    if len(scheme.kicks) % 2 == 1:
        forces.copy_array(u, next_u)
    forces.set_piston_velocities(chain, v, drive, 1.0)
    forces.tally_pistons(chain, before)
    return passed_limit


@advance_tick.register(DampedComposition)
def damped_tick(scheme, chain, drive, tick, tape):
    """Advance by drifts, kicks, and the dissipative flow; the tape also records the velocities before this flow."""
    h, a, n = chain.settings.step, chain.rows, chain.settings.grains
    u, next_u, v = a[U, : n + 2], a[OTHER_U, : n + 2], a[V, : n + 1]
    base_positions, before = forces.end_values(chain, u), forces.end_values(chain, v)
    middle, row = len(scheme.kicks) // 2, 0
    drift(u[1:-1], v[1:], scheme.drifts[0] * h)
    forces.place_pistons(chain, u, drive, base_positions, scheme.drifts[0])
    passed_limit = forces.update_peaks(u, a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])
    for s in range(len(scheme.kicks)):
        e = scheme.kick_times[s] + scheme.drifts[s + 1]
        if len(tape) > 0:
            forces.copy_array(u, tape[row])
            row += 1
        if s == middle:
            # During the dissipative flow prescribed grains move at the speed of the input in the middle of the step.
            forces.set_piston_velocities(chain, v, drive, 0.5)
            if len(tape) > 0:
                forces.copy_array(v, tape[row])
                row += 1
            apply_dissipation(chain, u)
            drift(u[1:-1], v[1:], scheme.drifts[s + 1] * h)
            _restore_pistons(chain, before)
            forces.place_pistons(chain, u, drive, base_positions, e)
        else:
            kick(chain, u, next_u, drive, (scheme.kick_times[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h))
            forces.place_pistons(chain, next_u, drive, base_positions, e)
            u, next_u = next_u, u
    # A symmetric damped composition has an even number of kicks, so after all swaps the displacements are in the row U.
    forces.set_piston_velocities(chain, v, drive, 1.0)
    forces.tally_pistons(chain, before)
    return passed_limit


@internal
def drift(u, v, time):
    """Drift: add `time` times the velocities to the displacements."""
    for i in range(len(u)):
        u[i] += time * v[i]


@internal
def kick_and_drift(law, u, next_u, velocities, constants, f, times):
    """Kick all grains except the last by the contact forces on each and by gravity, then drift from `u` to `next_u`.

    Displacements are read from one row and written to another: an in-place loop would not vectorise and take 1.4 times as long.

    Args:
        law: contact law.
        u: displacements of all columns.
        next_u: displacements after the drift; written.
        velocities: velocities of the grains; updated.
        constants: overlaps at rest of the contacts, inverse masses of the grains.
        f: force in the contact left of the first grain.
        times: duration of the kick; velocity that gravity adds in it; duration of the drift.

    Returns:
        The force in the contact right of the last of these grains.
    """
    left, right, moved = u[1:-2], u[2:-1], next_u[1:-2]
    rest, inverse_mass = constants
    time, fall, drift_time = times
    for i in range(len(left)):
        g = force(law, i + 1, forces.positive_part(left[i] - right[i] + rest[i]))
        v = (velocities[i] + (time * inverse_mass[i]) * (f - g)) + fall
        velocities[i] = v
        moved[i] = left[i] + drift_time * v
        f = g
    return f


@internal_inlined
def kick(chain, u, next_u, drive, stage):
    """Kick the velocities, then drift from `u` to `next_u`; tally the work and impulse of the ends.

    `stage` is the time of the kick as a fraction of the step, and the durations of kick and drift.
    """
    a, n, v = chain.rows, chain.settings.grains, chain.rows[V]
    e, time, drift_time = stage
    fall, before = time * chain.settings.gravity, forces.end_values(chain, v)
    # External forces on free ends replace the missing contact forces.
    first = forces.elastic_force(chain, u, 0) + forces.left_end_force(chain, drive, e)
    last = forces.elastic_force(chain, u, n) - forces.right_end_force(chain, drive, e)
    second, constants = forces.elastic_force(chain, u, 1), (a[REST_OVERLAP, 1:], a[INVERSE_MASS, 1:])
    f = kick_and_drift(chain.law, u, next_u, v[1:], constants, first, (time, fall, drift_time))
    v[n] = (v[n] + (time * a[INVERSE_MASS, n]) * (f - last)) + fall
    next_u[n] = u[n] + drift_time * v[n]
    _restore_pistons(chain, before)
    _tally_kick(chain, drive, (e, time), before, EndForces(first, second, f, last))


@internal_inlined
def _restore_pistons(chain, velocities):
    """Restore the velocities of prescribed grains, which gravity and contact forces must not change."""
    if chain.settings.left.is_piston:
        chain.rows[V, 1] = velocities[0]
    if chain.settings.right.is_piston:
        chain.rows[V, chain.settings.grains] = velocities[1]


@internal_inlined
def _tally_kick(chain, drive, stage, old_velocities, f):
    """Tally impulse and work of both ends in a kick; a free end moves at the mean of its velocities before and after."""
    left, right, tally = chain.settings.left, chain.settings.right, chain.rows[TALLY]
    first, last = forces.end_values(chain, chain.rows[V])
    e, time = stage
    forces.add_compensated(tally, IMPULSE_LEFT, time * f.first)
    if left.is_piston:
        forces.add_compensated(tally, IMPULSE_LEFT, time * f.second)
        forces.add_compensated(tally, WORK_LEFT, time * f.second * polynomial_value(drive.left, e))
    else:
        push = f.first if left.is_free else 0.0
        forces.add_compensated(tally, WORK_LEFT, time * push * (0.5 * (old_velocities[0] + first)))
    if right.is_piston:
        forces.add_compensated(tally, IMPULSE_RIGHT, -time * f.before_last)
        forces.add_compensated(tally, WORK_RIGHT, -time * f.before_last * polynomial_value(drive.right, e))
    else:
        pull = -f.last if right.is_free else 0.0
        forces.add_compensated(tally, IMPULSE_RIGHT, -time * f.last)
        forces.add_compensated(tally, WORK_RIGHT, time * pull * (0.5 * (old_velocities[1] + last)))
