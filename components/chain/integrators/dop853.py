"""DOP853, the reference: Dormand and Prince's explicit Runge-Kutta pair of order 8 with error control of orders 5 and 3.

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (Springer 1993), section II.10:
the tableau and the error estimate. Every tick begins anew with the whole tick as the first trial, so that the partition
of steps leaves no trace; a step is cut to end where an open contact would close. Square roots take the place of the
usual eighth root's pow.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from ...support.jit import internal
from .. import forces
from ..layout import FREE_ROW, INVERSE_MASS, LIMIT, MASS, PEAK, REST_OVERLAP, STIFFNESS, U, V
from .scheme import EXHAUSTED, one_tick

# Rows of the lower triangle of A, one after the other: row i begins at i (i - 1) / 2.
_A = np.array(
    [
        0.05260015195876773,
        0.0197250569845379,
        0.0591751709536137,
        0.02958758547680685,
        0.0,
        0.08876275643042054,
        0.2413651341592667,
        0.0,
        -0.8845494793282861,
        0.924834003261792,
        0.037037037037037035,
        0.0,
        0.0,
        0.17082860872947386,
        0.12546768756682242,
        0.037109375,
        0.0,
        0.0,
        0.17025221101954405,
        0.06021653898045596,
        -0.017578125,
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ]
)
_B = np.array(
    [
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ]
)
_C = np.array(
    [
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    ]
)
_E3 = np.array(
    [
        -0.18980075407240762,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        -0.4226823213237919,
        -0.1521609496625161,
        0.20136540080403034,
        0.02265179219836082,
    ]
)
_E5 = np.array(
    [
        0.01312004499419488,
        0.0,
        0.0,
        0.0,
        0.0,
        -1.2251564463762044,
        -0.4957589496572502,
        1.6643771824549864,
        -0.35032884874997366,
        0.3341791187130175,
        0.08192320648511571,
        -0.022355307863886294,
    ]
)

_STAGES = 12
_SAFETY, _SMALLEST_FACTOR, _LARGEST_FACTOR = 0.9, 0.2, 5.0
_SMALLEST_PART = 1e-9
# Trial steps of one tick at most, by the number of grains: two seconds or so of work. The first bound is for chains so short
# that more would not help, the last lets each of very many contacts close once.
_MOST_TRIALS, _TRIALS_TIMES_GRAINS, _LEAST_TRIALS = 1_000_000, 30_000_000, 1000
# Below this a growing tally is rounding.
_LEAST_TALLY_TOLERANCE = 1e-14
# Rounding of an overlap, which the weights of the stages make larger.
_ROUNDING = 16 * 2.220446049250313e-16

# Scratch: the stages' v, then their dv/dt, then a stage's u and v.
_SV, _SA, _SU, _SW = 0, _STAGES, 2 * _STAGES, 2 * _STAGES + 1
SCRATCH_ROWS = 2 * _STAGES + 2


class Dop853(NamedTuple):
    """The scheme, with its number of stages."""

    stages: int


DOP853 = Dop853(_STAGES)


@internal
def _parts_to_close(chain):
    """Return the steps until the first open contact closes at the present speeds; infinite if none does."""
    a, soonest = chain.rows, np.inf
    for j in range(chain.settings.grains + 1):
        gap = -(a[U, j] - a[U, j + 1] + a[REST_OVERLAP, j])
        speed = a[V, j] - a[V, j + 1]
        # A gap within the displacements' rounding is closed: no step is short enough to end where it closes.
        rounding = 1e-15 * (abs(a[U, j]) + abs(a[U, j + 1]))
        if gap > rounding and speed > 0.0 and a[STIFFNESS, j] > 0.0:
            soonest = min(soonest, gap / speed)
    return soonest / chain.settings.step


@internal
def _evaluate_stages(chain, drive, bases, e, part):
    """Evaluate the twelve derivatives of a trial from e to e + part."""
    u, v, rows = forces.displacements(chain), forces.velocities_and_tallies(chain), chain.rows[FREE_ROW:]
    h, stage_u, stage_v = chain.settings.step * part, rows[_SU, : len(u)], rows[_SW, : len(v)]
    for s in range(_STAGES):
        forces.copy(u, stage_u)
        forces.copy(v, stage_v)
        for q in range(s):
            weight = h * _A[s * (s - 1) // 2 + q]
            if weight != 0.0:
                _add(stage_u[1:-1], weight, rows[_SV + q, 1:])
                _add(stage_v[1:], weight, rows[_SA + q, 1:])
        at = e + _C[s] * part
        forces.place_pistons(chain, stage_u, drive, bases, at)
        forces.set_piston_velocities(chain, stage_v, drive, at)
        forces.copy(stage_v[: len(u) - 1], rows[_SV + s])
        forces.accelerations(chain, stage_u, stage_v, drive, at, rows[_SA + s, : len(v)])


@internal
def _add(target, weight, source):
    for i in range(len(target)):
        target[i] += weight * source[i]


@internal
def _fastest(chain, h):
    """Return the largest velocity of a grain, or the change of one in a time h."""
    first, fastest = chain.rows[FREE_ROW + _SA], 0.0
    for i in range(1, chain.settings.grains + 1):
        fastest = max(fastest, abs(chain.rows[V, i]), abs(first[i]) * h)
    return fastest


@internal
def _error(chain, h):
    """Return Hairer's combination of the two estimates, in the largest component, relative to the tolerance."""
    rows, fastest = chain.rows[FREE_ROW:], _fastest(chain, h)
    if fastest < 1e-290:  # at rest: 1 / (tolerance fastest) would overflow
        return 0.0
    worst5, worst3 = 0.0, 0.0
    for i in range(1, chain.settings.grains + 1):
        v5, v3, u5, u3 = 0.0, 0.0, 0.0, 0.0
        for s in range(_STAGES):
            v5 += _E5[s] * rows[_SA + s, i]
            v3 += _E3[s] * rows[_SA + s, i]
            u5 += _E5[s] * rows[_SV + s, i]
            u3 += _E3[s] * rows[_SV + s, i]
        # Displacements are measured by what the fastest grain does in a step.
        worst5 = max(worst5, abs(v5) * h, abs(u5))
        worst3 = max(worst3, abs(v3) * h, abs(u3))
    scale = 1.0 / (chain.settings.tolerance * fastest)
    return max(_error_norm(worst5 * scale, worst3 * scale), _tally_error(chain, h))


@internal
def _error_norm(error5, error3):
    norm = sqrt(error5 * error5 + 0.01 * error3 * error3)
    # 0 also where the squares underflow.
    return error5 * error5 / norm if norm > 0.0 else 0.0


@internal
def _tally_error(chain, h):
    """Return the error of work, loss and impulse, relative to kinetic energy and momentum and to what they grow by.

    Grains do not tell it: where a dissipative contact is cut off it carries no force, but gives up the energy left in it.
    """
    rows, n, energy, momentum = chain.rows[FREE_ROW:], chain.settings.grains, 0.0, 0.0
    for i in range(1, n + 1):
        # Pistons count too, which have no mass in the row of masses.
        mass = chain.settings.left.mass if i == 1 else chain.settings.right.mass if i == n else chain.rows[MASS, i]
        v = max(abs(chain.rows[V, i]), abs(rows[_SA, i]) * h)
        energy, momentum = energy + 0.5 * mass * v * v, momentum + mass * v
    tolerance, worst = chain.settings.tolerance, 0.0
    for k in range(5):
        error5, error3, largest = 0.0, 0.0, 0.0
        for s in range(_STAGES):
            rate = rows[_SA + s, n + 2 + k]
            error5 += _E5[s] * rate
            error3 += _E3[s] * rate
            largest = max(largest, abs(rate))
        allowed = tolerance * (energy if k in (0, 1, 4) else momentum) + max(tolerance, _LEAST_TALLY_TOLERANCE) * largest * h
        if allowed > 0.0:
            worst = max(worst, _error_norm(abs(error5) * h / allowed, abs(error3) * h / allowed))
    return worst


@internal
def _is_rounding(chain, h, error):
    """Return whether rounding an overlap does as much to the velocities in a time h as an error: no shorter step helps."""
    a, noise = chain.rows, 0.0
    for j in range(chain.settings.grains + 1):
        d = a[U, j] - a[U, j + 1] + a[REST_OVERLAP, j]
        if d > 0.0:
            rounded = _ROUNDING * (abs(a[U, j]) + abs(a[U, j + 1]) + abs(a[REST_OVERLAP, j]))
            slope = chain.settings.exponent * forces.elastic_force(chain, a[U], j) / d
            noise = max(noise, slope * rounded * (a[INVERSE_MASS, j] + a[INVERSE_MASS, j + 1]))
    return error * chain.settings.tolerance * _fastest(chain, h) <= noise * h


def most_trials(grains: int) -> int:
    """Return the trial steps that one tick may take."""
    return max(_LEAST_TRIALS, min(_MOST_TRIALS, _TRIALS_TIMES_GRAINS // (grains + 1)))


_most_trials = internal(most_trials)


@one_tick.register(Dop853)
def dop853_tick(scheme, chain, drive, tick, tape):
    """Advance by as many accepted steps as the tolerance asks for; `EXHAUSTED` where these are too many."""
    a, n, before = chain.rows, chain.settings.grains, forces.end_values(chain, chain.rows[V])
    u, v, rows, bases = a[U], forces.velocities_and_tallies(chain), a[FREE_ROW:], forces.end_values(chain, chain.rows[U])
    forces.place_pistons(chain, u, drive, bases, 0.0)
    forces.set_piston_velocities(chain, v, drive, 0.0)
    e, trial, trials, most = 0.0, 1.0, 0, _most_trials(n)
    while e < 1.0:
        trials += 1
        if trials > most:
            return EXHAUSTED
        part, closing = min(trial, 1.0 - e), _parts_to_close(chain)
        if closing > _SMALLEST_PART:
            part = min(part, closing)
        last, h = part >= 1.0 - e, chain.settings.step * part
        _evaluate_stages(chain, drive, bases, e, part)
        error = _error(chain, h)
        if not (error <= 1.0) and part > _SMALLEST_PART and not _is_rounding(chain, h, error):
            shrink = _SAFETY / sqrt(sqrt(sqrt(error))) if error < 1e100 else _SMALLEST_FACTOR
            trial = part * max(_SMALLEST_FACTOR, shrink)
            continue
        for s in range(_STAGES):
            _add(u[1 : n + 1], h * _B[s], rows[_SV + s, 1:])
            _add(v[1:], h * _B[s], rows[_SA + s, 1:])
        e = 1.0 if last else e + part
        forces.place_pistons(chain, u, drive, bases, e)
        forces.set_piston_velocities(chain, v, drive, e)
        grow = _SAFETY / sqrt(sqrt(sqrt(error))) if error > 1e-12 else _LARGEST_FACTOR
        trial = part * min(_LARGEST_FACTOR, max(_SMALLEST_FACTOR, grow))
    forces.book_pistons(chain, before)
    return int(forces.note_peaks(a[U], a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1]))
