"""The backward sweep: the transpose of each drift, kick and dissipative flow, in reverse order, at the states of the tape.

The adjoint of a chain is a table like that of the chain; each entry is the derivative dJ/dx of the objective, x being the same
entry of the chain. While a stage is reversed, scratch rows hold for each grain c = dJ/d(force on it) = kick w v_adjoint
(FORCE_ADJOINT) and the sum of c times this force (INVERSE_MASS_SUM, w dJ/dw with the inverse mass w), and for each contact its
force F (FORCE) and dJ/d(overlap) = dF/dd dJ/dF (OVERLAP_ADJOINT).
"""

from __future__ import annotations

from ...support.dispatch import dispatch_by_class
from ...support.jit import internal_inlined
from .. import forces
from ..integrators.compositions import Composition, DampedComposition
from ..integrators.dissipative_step import acting_time, apply_half_sweep, is_closing, prepare_impulses, sweep_fraction
from ..laws.functions import damping, damping_pullback, force, force_pullback, has_force_jump
from ..layout import (
    DISSIPATION,
    GRAVITY,
    HISTORY,
    INVERSE_MASS,
    LEFT_DRIVE,
    LEFT_STATIC,
    LOST,
    OTHER_U,
    REST_OVERLAP,
    RIGHT_DRIVE,
    RIGHT_STATIC,
    SCALARS,
    U,
    V,
)  # fmt: skip

# Scratch of the adjoint table. The dissipative part uses the approaches before each half sweep, and two additional rows.
OVERLAP_ADJOINT, FORCE, FORCE_ADJOINT = range(DISSIPATION, DISSIPATION + 3)
INVERSE_MASS_SUM = LEFT_DRIVE
_PER_SPEED_ADJOINT, _LEAST_ADJOINT = DISSIPATION, DISSIPATION + 1
_APPROACHES = (RIGHT_DRIVE, HISTORY, HISTORY + 1)
_SPEED_ADJOINT, _IMPULSE = HISTORY + 2, LOST


@dispatch_by_class
def reverse_tick(scheme, chain, adjoint, inputs, input_adjoint, tape):
    """Propagate the adjoint from the end of a tick to its beginning, and add the derivatives for the inputs.

    Args:
        scheme: the integrator.
        chain: a `ChainState` with the constants of the run.
        adjoint: a `ChainState` of the adjoint table.
        inputs: held left and right inputs, shape (2,).
        input_adjoint: derivatives with respect to the inputs, shape (2,); updated.
        tape: the rows that `advance_tick` wrote in this tick.
    """


@reverse_tick.register(Composition)
def reverse_composed_tick(scheme, chain, adjoint, inputs, input_adjoint, tape):
    """Reverse the kicks and drifts of a tick."""
    stages, h = len(scheme.kicks), chain.settings.step
    _reverse_piston_speeds(chain, adjoint, input_adjoint)
    base_adjoints = _reverse_positions(chain, adjoint, input_adjoint, scheme.kick_times[stages - 1] + scheme.drifts[stages])
    for back in range(stages):
        s = stages - 1 - back
        e = scheme.drifts[0] if s == 0 else scheme.kick_times[s - 1] + scheme.drifts[s]
        _reverse_kick(
            chain,
            adjoint,
            inputs,
            input_adjoint,
            tape[s],
            (scheme.kick_times[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h),
        )
        placed = _reverse_positions(chain, adjoint, input_adjoint, e)
        base_adjoints = base_adjoints[0] + placed[0], base_adjoints[1] + placed[1]
    _reverse_first_drift(chain, adjoint, base_adjoints, scheme.drifts[0] * h)


@reverse_tick.register(DampedComposition)
def reverse_damped_tick(scheme, chain, adjoint, inputs, input_adjoint, tape):
    """Reverse the kicks, drifts and the dissipative flow of a tick."""
    stages, h, row = len(scheme.kicks), chain.settings.step, len(tape)
    _reverse_piston_speeds(chain, adjoint, input_adjoint)
    base_adjoints = _reverse_positions(chain, adjoint, input_adjoint, scheme.kick_times[stages - 1] + scheme.drifts[stages])
    for back in range(stages):
        s = stages - 1 - back
        e = scheme.drifts[0] if s == 0 else scheme.kick_times[s - 1] + scheme.drifts[s]
        row -= 1
        if s == stages // 2:
            row -= 1
            _reverse_drift(chain, adjoint, 0.0, scheme.drifts[s + 1] * h)
            # During the dissipative flow the speeds of pistons are the inputs; before and after it they have no effect.
            _clear_piston_speed_adjoints(chain, adjoint)
            _reverse_dissipation(chain, adjoint, tape[row], tape[row + 1])
            _reverse_piston_speeds(chain, adjoint, input_adjoint)
        else:
            stage = (scheme.kick_times[s], scheme.kicks[s] * h, scheme.drifts[s + 1] * h)
            _reverse_kick(chain, adjoint, inputs, input_adjoint, tape[row], stage)
        placed = _reverse_positions(chain, adjoint, input_adjoint, e)
        base_adjoints = base_adjoints[0] + placed[0], base_adjoints[1] + placed[1]
    _reverse_first_drift(chain, adjoint, base_adjoints, scheme.drifts[0] * h)


@internal_inlined
def _reverse_kick(chain, adjoint, inputs, input_adjoint, u, stage):
    """Reverse a kick and the drift after it; `stage` is as in `compositions.kick`, u the displacements of the kick."""
    _, kick, drift = stage
    _reverse_drift(chain, adjoint, kick, drift)
    _reverse_forces(chain, adjoint, u)
    _reverse_end_forces(chain, adjoint, inputs, input_adjoint)
    _reverse_gravity(chain, adjoint, kick)
    _reverse_overlaps(chain.settings.grains, adjoint.rows)


@internal_inlined
def _reverse_drift(chain, adjoint, kick, drift):
    """Add `drift` times u_adjoint to v_adjoint, and write the adjoint of the force on each grain in the kick before it."""
    a, n = adjoint.rows, chain.settings.grains
    u, v, c, w = a[U, 1 : n + 1], a[V, 1 : n + 1], a[FORCE_ADJOINT, 1 : n + 1], chain.rows[INVERSE_MASS, 1 : n + 1]
    for i in range(n):
        v[i] += drift * u[i]
        c[i] = (kick * w[i]) * v[i]


@internal_inlined
def _reverse_forces(chain, adjoint, u):
    """Propagate adjoints from grain forces to the constants and overlaps of contacts, in short loops that vectorise."""
    a, n, law, left, right = adjoint.rows, chain.settings.grains, chain.law, u[:-1], u[1:]
    overlaps, rest, values = a[OTHER_U, : n + 1], chain.rows[REST_OVERLAP], a[FORCE]
    before, after, by_overlap, by_rest = a[FORCE_ADJOINT, :-1], a[FORCE_ADJOINT, 1:], a[OVERLAP_ADJOINT], a[REST_OVERLAP]
    for j in range(n + 1):
        overlaps[j] = forces.positive_part(left[j] - right[j] + rest[j])
    for j in range(n + 1):
        values[j] = force(law, j, overlaps[j])
    for j in range(n + 1):
        by_overlap[j] = force_pullback(law, adjoint.law, j, overlaps[j], after[j] - before[j])
    for j in range(n + 1):
        by_rest[j] += by_overlap[j]


@internal_inlined
def _reverse_overlaps(n, a):
    """Propagate adjoints from overlaps to displacements, and from forces on grains to their inverse masses."""
    u, sums, c = a[U, 1 : n + 1], a[INVERSE_MASS_SUM, 1 : n + 1], a[FORCE_ADJOINT, 1 : n + 1]
    left, right, left_force, right_force = a[OVERLAP_ADJOINT, :n], a[OVERLAP_ADJOINT, 1:], a[FORCE, :n], a[FORCE, 1:]
    for i in range(n):
        u[i] += right[i] - left[i]
        sums[i] += c[i] * (left_force[i] - right_force[i])


@internal_inlined
def _reverse_end_forces(chain, adjoint, inputs, input_adjoint):
    """At a free end, put the force on the end in the place of a contact force; add its adjoint to input and static force."""
    a, n, left, right = adjoint.rows, chain.settings.grains, chain.settings.left, chain.settings.right
    if left.is_free:
        a[FORCE, 0] = left.static_force + inputs[0]
        input_adjoint[0] += a[FORCE_ADJOINT, 1]
        a[SCALARS, LEFT_STATIC] += a[FORCE_ADJOINT, 1]
    if right.is_free:
        a[FORCE, n] = right.static_force - inputs[1]
        input_adjoint[1] += a[FORCE_ADJOINT, n]
        a[SCALARS, RIGHT_STATIC] -= a[FORCE_ADJOINT, n]


@internal_inlined
def _reverse_gravity(chain, adjoint, kick):
    if chain.settings.gravity != 0.0:
        low = 2 if chain.settings.left.is_piston else 1
        high = chain.settings.grains + (0 if chain.settings.right.is_piston else 1)
        total = 0.0
        for i in range(low, high):
            total += adjoint.rows[V, i]
        adjoint.rows[SCALARS, GRAVITY] += kick * total


# -- pistons ------------------------------------------------------------------------------------------------------------


@internal_inlined
def _reverse_positions(chain, adjoint, input_adjoint, e):
    """Reverse `forces.place_pistons`; return the adjoints of the positions at the tick."""
    u, h, n, left, right = adjoint.rows[U], chain.settings.step, chain.settings.grains, 0.0, 0.0
    if chain.settings.left.is_piston:
        left, u[1] = u[1], 0.0
        input_adjoint[0] += h * e * left
    if chain.settings.right.is_piston:
        right, u[n] = u[n], 0.0
        input_adjoint[1] += h * e * right
    return left, right


@internal_inlined
def _reverse_piston_speeds(chain, adjoint, input_adjoint):
    """Reverse the speeds of prescribed grains, which equal the inputs."""
    if chain.settings.left.is_piston:
        input_adjoint[0] += adjoint.rows[V, 1]
    if chain.settings.right.is_piston:
        input_adjoint[1] += adjoint.rows[V, chain.settings.grains]
    _clear_piston_speed_adjoints(chain, adjoint)


@internal_inlined
def _clear_piston_speed_adjoints(chain, adjoint):
    if chain.settings.left.is_piston:
        adjoint.rows[V, 1] = 0.0
    if chain.settings.right.is_piston:
        adjoint.rows[V, chain.settings.grains] = 0.0


@internal_inlined
def _reverse_first_drift(chain, adjoint, base_adjoints, drift):
    """Reverse the first drift of a tick; prescribed grains get the adjoints of their positions at the tick."""
    a, n = adjoint.rows, chain.settings.grains
    _reverse_drift(chain, adjoint, 0.0, drift)
    if chain.settings.left.is_piston:
        a[U, 1], a[V, 1] = base_adjoints[0], 0.0
    if chain.settings.right.is_piston:
        a[U, n], a[V, n] = base_adjoints[1], 0.0


# -- the dissipative part of a step ---------------------------------------------------------------------------------------


@internal_inlined
def _reverse_dissipation(chain, adjoint, u, v):
    """Reverse the flow of the dissipative forces at the displacements u, with the velocities v before it."""
    a, b, n = chain.rows, adjoint.rows, chain.settings.grains
    forces.copy_array(v[: n + 2], a[V])
    forces.fill_array(b[_PER_SPEED_ADJOINT], 0.0)
    forces.fill_array(b[_LEAST_ADJOINT], 0.0)
    prepare_impulses(chain, u)
    for sweep in range(3):
        for j in range(n + 1):
            b[_APPROACHES[sweep], j] = a[V, j] - a[V, j + 1]
        if sweep < 2:
            apply_half_sweep(chain, sweep)
    for back in range(3):
        _reverse_half_sweep(a, b, n, b[_APPROACHES[2 - back]], back % 2)
    _reverse_impulse_factors(chain, adjoint, u)
    for i in range(1, n + 1):
        b[U, i] += b[_PER_SPEED_ADJOINT, i] - b[_PER_SPEED_ADJOINT, i - 1]
        b[V, i] += b[_LEAST_ADJOINT, i] - b[_LEAST_ADJOINT, i - 1]


@internal_inlined
def _reverse_half_sweep(a, b, n, approach, parity):
    """Reverse a half sweep: pass its adjoints to velocities, inverse masses, impulses per approach speed and least impulses."""
    for j in range(n + 1):
        acts = j % 2 == parity
        free, least = a[DISSIPATION, j] * approach[j], a[DISSIPATION + 1, j]
        held = free > least
        by_impulse = a[INVERSE_MASS, j + 1] * b[V, j + 1] - a[INVERSE_MASS, j] * b[V, j]
        by_impulse = by_impulse if acts else 0.0
        given = by_impulse if held else 0.0
        b[_PER_SPEED_ADJOINT, j] += given * approach[j]
        b[_LEAST_ADJOINT, j] += by_impulse - given
        b[_SPEED_ADJOINT, j] = a[DISSIPATION, j] * given
        b[_IMPULSE, j] = (free if held else least) if acts else 0.0
    for i in range(1, n + 1):
        b[INVERSE_MASS, i] += b[V, i] * (b[_IMPULSE, i - 1] - b[_IMPULSE, i])
        b[V, i] += b[_SPEED_ADJOINT, i] - b[_SPEED_ADJOINT, i - 1]


@internal_inlined
def _reverse_impulse_factors(chain, adjoint, u):
    """Reverse `prepare_impulses`: replace the adjoints of its results by those of overlaps and approaches."""
    a, b, law, h = chain.rows, adjoint.rows, chain.law, chain.settings.step
    for j in range(chain.settings.grains + 1):
        middle, w = u[j] - u[j + 1] + a[REST_OVERLAP, j], b[_APPROACHES[0], j]
        d = forces.positive_part(middle)
        time = acting_time(law, middle, w, h) * sweep_fraction(j)
        coefficient = damping(law, j, d)
        c = coefficient * time
        y = 0.5 * c * (a[INVERSE_MASS, j] + a[INVERSE_MASS, j + 1])
        by_damping, by_masses = _impulse_slopes(c, y)
        per_speed, least = b[_PER_SPEED_ADJOINT, j], b[_LEAST_ADJOINT, j]
        b[INVERSE_MASS, j] += per_speed * by_masses
        b[INVERSE_MASS, j + 1] += per_speed * by_masses
        g = force_pullback(law, adjoint.law, j, d, -least * time)
        g += damping_pullback(law, adjoint.law, j, d, per_speed * by_damping * time)
        by_approach = 0.0
        if has_force_jump(law) and is_closing(middle, w, h):
            by_time = sweep_fraction(j) * (per_speed * by_damping * coefficient - least * force(law, j, d))
            g += by_time / w
            by_approach = -by_time * middle / (w * w)
        b[REST_OVERLAP, j] += g
        b[_PER_SPEED_ADJOINT, j], b[_LEAST_ADJOINT, j] = g, by_approach


@internal_inlined
def _impulse_slopes(c, y):
    """Return the derivatives of the impulse per speed c q(y), q = (1 + y) / (1 + 2 y + 2 y^2), by c and by an inverse mass."""
    below = 1.0 / (1.0 + 2.0 * y * (1.0 + y))
    q, slope = (1.0 + y) * below, -(1.0 + y * (4.0 + 2.0 * y)) * (below * below)
    return q + y * slope, (0.5 * c * c) * slope
