"""The classical Runge-Kutta scheme of order 4, one of the two used by Nesterenko (1983)."""

from __future__ import annotations

from typing import NamedTuple

from ...support.jit import internal
from .. import forces
from ..layout import FREE_ROW, LIMIT, PEAK, REST_OVERLAP, U, V
from .scheme import advance_tick

SCRATCH_ROWS = 5


class RungeKutta(NamedTuple):
    """Coefficients of the scheme: the times of its four stages as fractions of the step."""

    parts: tuple[float, ...]


RK4 = RungeKutta((0.0, 0.5, 0.5, 1.0))


@advance_tick.register(RungeKutta)
def runge_kutta_tick(scheme, chain, drive, tick, tape):
    """Advance by one step of the scheme."""
    a, n, before = chain.rows, chain.settings.grains, forces.end_values(chain, chain.rows[V])
    runge_kutta_step(scheme, chain, drive, a[FREE_ROW:])
    forces.tally_pistons(chain, before)
    return forces.update_peaks(a[U], a[REST_OVERLAP], a[LIMIT], a[PEAK, : n + 1])


@internal
def runge_kutta_step(scheme, chain, drive, scratch):
    """Take one step of u and v; the last five entries of v are the tallies of the ends.

    The five scratch rows are u, v and dv/dt of a stage, and the weighted sums of v and dv/dt.
    """
    u, v, h = forces.displacements(chain), forces.velocities_and_tallies(chain), chain.settings.step
    stage_u, stage_v, rate = scratch[0, : len(u)], scratch[1, : len(v)], scratch[2, : len(v)]
    sum_v, sum_rate = scratch[3, : len(v)], scratch[4, : len(v)]
    base_positions = forces.end_values(chain, u)
    forces.copy_array(u, stage_u)
    forces.copy_array(v, stage_v)
    for row in (rate, sum_v, sum_rate):
        forces.fill_array(row, 0.0)
    forces.place_pistons(chain, stage_u, drive, base_positions, 0.0)
    forces.set_piston_velocities(chain, stage_v, drive, 0.0)
    for stage in range(4):
        weight = (1.0 if stage == 0 or stage == 3 else 2.0) / 6.0
        forces.accelerations(chain, stage_u, stage_v, drive, scheme.parts[stage], rate)
        for i in range(1, len(v)):
            sum_v[i] += weight * stage_v[i]
            sum_rate[i] += weight * rate[i]
        if stage < 3:
            part = scheme.parts[stage + 1]
            for i in range(1, len(u) - 1):
                stage_u[i] = u[i] + part * h * stage_v[i]
            for i in range(1, len(v)):
                stage_v[i] = v[i] + part * h * rate[i]
            forces.place_pistons(chain, stage_u, drive, base_positions, part)
            forces.set_piston_velocities(chain, stage_v, drive, part)
    for i in range(1, len(u) - 1):
        u[i] += h * sum_v[i]
    for i in range(1, len(v)):
        v[i] += h * sum_rate[i]
    forces.place_pistons(chain, u, drive, base_positions, 1.0)
    forces.set_piston_velocities(chain, v, drive, 1.0)
