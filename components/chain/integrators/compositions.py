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
from ..drive import value
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
from .dissipative_step import dissipate
from .scheme import one_tick


class Composition(NamedTuple):
    """Alternating drifts and kicks as fractions of the step, and the fraction of the step that has passed at each kick."""

    drifts: tuple[float, ...]
    kicks: tuple[float, ...]
    passed: tuple[float, ...]


class DampedComposition(NamedTuple):
    """The same, with the dissipative flow as the middle kick."""

    drifts: tuple[float, ...]
    kicks: tuple[float, ...]
    passed: tuple[float, ...]


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


@one_tick.register(Composition)
def composed_tick(scheme, chain, drive, tick, tape):
    """Advance by drifts and kicks; record the displacements at each kick if the tape has rows."""
    h, a, n = chain.settings.step, chain.rows, chain.settings.grains
    here, there, v = a[U, : n + 2], a[OTHER_U, : n + 2], a[V, : n + 1]
    bases, before = forces.end_values(chain, here), forces.end_values(chain, v)
    drift(here[1:-1], v[1:], scheme.drifts[0] * h)
    forces.place_pistons(chain, here, drive, bases, scheme.drifts[0])
    passed_limit = forces.note_peaks(here, a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])
    for s in range(len(scheme.kicks)):
        if len(tape) > 0:
            forces.copy(here, tape[s])
        kick(chain, here, there, drive, (scheme.passed[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h))
        forces.place_pistons(chain, there, drive, bases, scheme.passed[s] + scheme.drifts[s + 1])
        here, there = there, here
    if len(scheme.kicks) % 2 == 1:
        forces.copy(here, there)
    forces.set_piston_velocities(chain, v, drive, 1.0)
    forces.book_pistons(chain, before)
    return passed_limit


@one_tick.register(DampedComposition)
def damped_tick(scheme, chain, drive, tick, tape):
    """Advance by drifts, kicks, and the dissipative flow; the tape also records the velocities before this flow."""
    h, a, n = chain.settings.step, chain.rows, chain.settings.grains
    here, there, v = a[U, : n + 2], a[OTHER_U, : n + 2], a[V, : n + 1]
    bases, before = forces.end_values(chain, here), forces.end_values(chain, v)
    middle, row = len(scheme.kicks) // 2, 0
    drift(here[1:-1], v[1:], scheme.drifts[0] * h)
    forces.place_pistons(chain, here, drive, bases, scheme.drifts[0])
    passed_limit = forces.note_peaks(here, a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])
    for s in range(len(scheme.kicks)):
        e = scheme.passed[s] + scheme.drifts[s + 1]
        if len(tape) > 0:
            forces.copy(here, tape[row])
            row += 1
        if s == middle:
            # During the flow prescribed grains move at the mid-step speed.
            forces.set_piston_velocities(chain, v, drive, 0.5)
            if len(tape) > 0:
                forces.copy(v, tape[row])
                row += 1
            dissipate(chain, here)
            drift(here[1:-1], v[1:], scheme.drifts[s + 1] * h)
            _restore_pistons(chain, before)
            forces.place_pistons(chain, here, drive, bases, e)
        else:
            kick(chain, here, there, drive, (scheme.passed[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h))
            forces.place_pistons(chain, there, drive, bases, e)
            here, there = there, here
    # A symmetric damped composition has an even number of kicks: the displacements are back in their row.
    forces.set_piston_velocities(chain, v, drive, 1.0)
    forces.book_pistons(chain, before)
    return passed_limit


@internal
def drift(u, v, time):
    """Advance displacements."""
    for i in range(len(u)):
        u[i] += time * v[i]


@internal
def kick_and_drift(law, here, there, velocities, constants, f, times):
    """Kick all grains except the last by the contact forces on each and by gravity, then drift from `here` to `there`.

    Displacements are read from one row and written to another: an in-place loop would not vectorise and take 1.4 times as long.

    Args:
        law: of the contacts.
        here: displacements of all columns.
        there: displacements after the drift; written.
        velocities: of the grains; written.
        constants: overlaps at rest of the contacts, inverse masses of the grains.
        f: force left of the first grain.
        times: duration of the kick; velocity that gravity adds in it; duration of the drift.

    Returns:
        The force right of the last of these grains.
    """
    left, right, moved = here[1:-2], here[2:-1], there[1:-2]
    rest, inverse_mass = constants
    time, fall, drift_time = times
    for i in range(len(left)):
        g = force(law, i + 1, forces.pressed(left[i] - right[i] + rest[i]))
        v = (velocities[i] + (time * inverse_mass[i]) * (f - g)) + fall
        velocities[i] = v
        moved[i] = left[i] + drift_time * v
        f = g
    return f


@internal_inlined
def kick(chain, here, there, drive, stage):
    """Kick the velocities, then drift from `here` to `there`; tally the work and impulse of the ends.

    `stage` is the time of the kick as a fraction of the step, and the durations of kick and drift.
    """
    a, n, v = chain.rows, chain.settings.grains, chain.rows[V]
    e, time, drift_time = stage
    fall, before = time * chain.settings.gravity, forces.end_values(chain, v)
    # External forces on free ends replace the missing contact forces.
    first = forces.elastic_force(chain, here, 0) + forces.left_push(chain, drive, e)
    last = forces.elastic_force(chain, here, n) - forces.right_push(chain, drive, e)
    second, constants = forces.elastic_force(chain, here, 1), (a[REST_OVERLAP, 1:], a[INVERSE_MASS, 1:])
    f = kick_and_drift(chain.law, here, there, v[1:], constants, first, (time, fall, drift_time))
    v[n] = (v[n] + (time * a[INVERSE_MASS, n]) * (f - last)) + fall
    there[n] = here[n] + drift_time * v[n]
    _restore_pistons(chain, before)
    _book_kick(chain, drive, (e, time), before, EndForces(first, second, f, last))


@internal_inlined
def _restore_pistons(chain, velocities):
    """Restore the velocities of prescribed grains, which gravity and contacts do not change."""
    if chain.settings.left.is_piston:
        chain.rows[V, 1] = velocities[0]
    if chain.settings.right.is_piston:
        chain.rows[V, chain.settings.grains] = velocities[1]


@internal_inlined
def _book_kick(chain, drive, stage, before, f):
    """Tally impulse and work of both ends in a kick; a free end moves at the mean of its velocities before and after."""
    left, right, tally = chain.settings.left, chain.settings.right, chain.rows[TALLY]
    first, last = forces.end_values(chain, chain.rows[V])
    e, time = stage
    forces.add(tally, IMPULSE_LEFT, time * f.first)
    if left.is_piston:
        forces.add(tally, IMPULSE_LEFT, time * f.second)
        forces.add(tally, WORK_LEFT, time * f.second * value(drive.left, e))
    else:
        push = f.first if left.is_free else 0.0
        forces.add(tally, WORK_LEFT, time * push * (0.5 * (before[0] + first)))
    if right.is_piston:
        forces.add(tally, IMPULSE_RIGHT, -time * f.before_last)
        forces.add(tally, WORK_RIGHT, -time * f.before_last * value(drive.right, e))
    else:
        pull = -f.last if right.is_free else 0.0
        forces.add(tally, IMPULSE_RIGHT, -time * f.last)
        forces.add(tally, WORK_RIGHT, time * pull * (0.5 * (before[1] + last)))
