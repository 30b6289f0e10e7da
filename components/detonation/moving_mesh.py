"""The gas on a moving mesh: cells that shrink and grow uniformly between pistons.

Face i of n cells moves at w_i, linear from the left end to the right one. A cell of length d contains the conserved amount d U:

    d(t + h) U(t + h) = d(t) U(t) - h (G_i+1 - G_i),    G_i = F - w_i U at the face.

G is the flux in the frame of the face, transformed back (Galileo), so that a uniform flow is preserved to rounding. On a piston
the pressure is exact for a wall that moves into the gas (shock) or away from it (rarefaction).
Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 4.3; Donea et al., Arbitrary
Lagrangian-Eulerian methods, in the Encyclopedia of Computational Mechanics (2004).
"""

from __future__ import annotations

from math import sqrt

from ..support.jit import internal, jit
from .boundaries import PISTON
from .fluxes import hllc_flux, piston_pressure
from .kernel_arrays import ENDS_TOO_FAST, LEFT_VELOCITY, POWER, RIGHT_VELOCITY, TOO_FAST_AHEAD, Medium, Tables
from .kernels import (
    LARGEST_COURANT,
    add_heat,
    compute_end_fluxes,
    compute_slopes,
    fill_ghost_cells,
    finish_tick,
    tally_end_flows,
    write_heun_stage,
    write_start_stage,
)

# Entries of the walls: positions of the ends, and mean pressures on them over the last tick.
LEFT, RIGHT, LEFT_WALL_PRESSURE, RIGHT_WALL_PRESSURE, WALLS = 0, 1, 2, 3, 4
# Entry of `front_positions` for a cell that no front has passed.
NOWHERE = -1e300


@jit
def advance(tables, walls, front_positions, signals, first_tick, events, failure):
    """Advance as `kernels.advance` does, with moving ends; the cross-section is one constant number.

    Args:
        tables: `kernel_arrays.Tables`; the cell size of its medium has no effect.
        walls: positions of the ends and pressures on them, shape (WALLS,); updated.
        front_positions: position of each cell when the front passed it, shape (n,) [m]; updated.
        signals: the means of the inputs over each tick, shape (ticks, SIGNALS).
        first_tick: number at the beginning of the first of these ticks.
        events: `kernel_arrays.Events`, updated.
        failure: cell and tick of a failure, shape (2,).
    """
    given, state = tables.medium, tables.state
    n, step = state.density.size, given.step_size
    for row in range(signals.shape[0]):
        tick = first_tick + row + 1
        failure[1] = tick
        velocities = (signals[row, LEFT_VELOCITY], signals[row, RIGHT_VELOCITY])
        before = (walls[RIGHT] - walls[LEFT]) / n
        motion = (velocities[0], (velocities[1] - velocities[0]) / n)
        status = refuse_long_tick(given, state, motion, before, failure)
        if status != 0:
            return status
        walls[LEFT] += step * velocities[0]
        walls[RIGHT] += step * velocities[1]
        after = (walls[RIGHT] - walls[LEFT]) / n
        status = heun_step(tables, walls, signals[row], velocities, (before, after), tick, events, failure)
        if status != 0:
            return status
        medium = Medium(
            given.gamma, given.gas_constant, given.heat, after, step, given.limiter, given.outside_temperature
        )  # fmt: skip
        now = Tables(medium, tables.tube, state, tables.scratch, tables.tally)
        add_heat(now, signals[row, POWER])
        status = finish_tick(now, motion, tick, events, failure)
        if status != 0:
            return status
        for i in range(n):
            if state.arrival[i] >= 0.0 and front_positions[i] == NOWHERE:
                front_positions[i] = walls[LEFT] + (i + 0.5) * after
    return 0


@internal
def refuse_long_tick(medium, state, motion, size, failure):
    """Return a status if waves cross a cell too fast, relative to the cell, or if the ends approach too fast; otherwise 0.

    `failure` then contains the cell with the fastest waves, so that a stable step for this cell is stable for all cells.
    """
    step, fastest, fits = medium.step_size, 0.0, True
    allowed = LARGEST_COURANT * size / step
    for i in range(state.density.size):
        relative = state.velocity[i] - (motion[0] + (i + 0.5) * motion[1])
        speed = abs(relative) + sqrt(medium.gamma * state.pressure[i] / state.density[i])
        if not speed <= fastest:
            fastest, failure[0] = speed, i
        if not speed <= allowed:
            fits = False
    if not fits:
        return TOO_FAST_AHEAD
    return 0 if size + step * motion[1] > 0.5 * size else ENDS_TOO_FAST


@internal
def heun_step(tables, walls, signals, velocities, sizes, tick, events, failure):
    """Move gas and faces by one Heun step, as `kernels.heun_step` does; return 0 or a status.

    Args:
        tables: as in `advance`.
        walls: as in `advance`.
        signals: inputs of the tick.
        velocities: velocities of the two ends [m/s].
        sizes: length of a cell before and after the tick [m].
        tick: number at the end of the tick.
        events: updated.
        failure: cell and tick of a failure.
    """
    state, step, (before, after) = tables.state, tables.medium.step_size, sizes
    first, f = tables.scratch.first, tables.scratch.fluxes
    write_start_stage(state, tables.scratch.stage)
    walls[LEFT_WALL_PRESSURE] = walls[RIGHT_WALL_PRESSURE] = 0.0
    compute_fluxes(tables, walls, signals, velocities, tick, events)
    tally_end_flows(tables)
    for i in range(state.density.size):
        first[0, i] = (before * state.density[i] - step * (f[0, i + 1] - f[0, i])) / after
        first[1, i] = (before * state.momentum[i] - step * (f[1, i + 1] - f[1, i])) / after
        first[2, i] = (before * state.energy[i] - step * (f[2, i + 1] - f[2, i])) / after
        first[3, i] = (before * state.fuel[i] - step * (f[3, i + 1] - f[3, i])) / after
    status = write_heun_stage(tables, failure)
    if status != 0:
        return status
    compute_fluxes(tables, walls, signals, velocities, tick, events)
    tally_end_flows(tables)
    half = 0.5 / after
    for i in range(state.density.size):
        state.density[i] = half * (before * state.density[i] + (after * first[0, i] - step * (f[0, i + 1] - f[0, i])))
        state.momentum[i] = half * (before * state.momentum[i] + (after * first[1, i] - step * (f[1, i + 1] - f[1, i])))
        state.energy[i] = half * (before * state.energy[i] + (after * first[2, i] - step * (f[2, i + 1] - f[2, i])))
        state.fuel[i] = half * (before * state.fuel[i] + (after * first[3, i] - step * (f[3, i + 1] - f[3, i])))
    return 0


@internal
def compute_fluxes(tables, walls, signals, velocities, tick, events):
    """Write the fluxes through all moving faces, for the stage in scratch."""
    medium, ends, scratch, n = tables.medium, tables.tube.ends, tables.scratch, tables.state.density.size
    fill_ghost_cells(tables)
    density, velocity, pressure, fraction = scratch.stage[0], scratch.stage[1], scratch.stage[2], scratch.stage[3]
    if ends[0] == PISTON:
        velocity[0] = 2.0 * velocities[0] - velocity[1]
    if ends[1] == PISTON:
        velocity[n + 1] = 2.0 * velocities[1] - velocity[n]
    compute_slopes(medium.limiter, scratch)
    dr, du, dp, dy = scratch.slopes[0], scratch.slopes[1], scratch.slopes[2], scratch.slopes[3]
    mass, impulse, energy, fuel = scratch.fluxes[0], scratch.fluxes[1], scratch.fluxes[2], scratch.fluxes[3]
    change = (velocities[1] - velocities[0]) / n
    for i in range(1, n):
        j, w = i + 1, velocities[0] + i * change
        left = (density[i] + dr[i], velocity[i] + du[i] - w, pressure[i] + dp[i], fraction[i] + dy[i])
        right = (density[j] - dr[j], velocity[j] - du[j] - w, pressure[j] - dp[j], fraction[j] - dy[j])
        m, f, e, y = hllc_flux(medium, left, right)
        mass[i], impulse[i], energy[i], fuel[i] = m, f + w * m, e + w * (f + 0.5 * w * m), y
    compute_end_fluxes(tables, signals, tick, events)
    for side in range(2):
        if ends[side] == PISTON:
            i, face, sign, w = (1, 0, -1.0, velocities[0]) if side == 0 else (n, n, 1.0, velocities[1])
            out = sign * (velocity[i] - w) + du[i]
            p = piston_pressure(medium.gamma, density[i] + sign * dr[i], out, pressure[i] + sign * dp[i])
            mass[face], impulse[face], energy[face], fuel[face] = 0.0, p, p * w, 0.0
            walls[LEFT_WALL_PRESSURE + side] += 0.5 * p
