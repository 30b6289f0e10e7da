"""The gas on a moving mesh: cells that shrink and grow evenly between pistons.

Face i of n cells moves with w_i, linear from the left end to the right one; a cell of length d holds d U of what is conserved:

    d(t + h) U(t + h) = d(t) U(t) - h (G_i+1 - G_i),    G_i = F - w_i U at the face.

G is the flux of the state as seen from the face, transformed back (Galileo): gas that moves evenly keeps its state to rounding.
On a piston the pressure is the exact one of a wall that runs into the gas (shock) or away from it (rarefaction).
Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 4.3; Donea et al., Arbitrary
Lagrangian-Eulerian methods, in the Encyclopedia of Computational Mechanics (2004).
"""

from __future__ import annotations

from math import sqrt

from ..support.jit import internal, jit
from .boundaries import PISTON
from .fluxes import hllc_flux, piston_pressure
from .kernel_arrays import ENDS_TOO_FAST, LEFT_VELOCITY, NOT_POSITIVE, POWER, RIGHT_VELOCITY, TOO_FAST_AHEAD, Medium
from .kernels import LARGEST_COURANT, add_heat, compute_end_fluxes, compute_slopes, fill_ghosts, finish, tally_ends

# Columns of the walls: where the ends are, and the mean pressure on them over the last tick.
LEFT, RIGHT, LEFT_WALL_PRESSURE, RIGHT_WALL_PRESSURE, WALLS = 0, 1, 2, 3, 4
# Where no front has come by, in `places`.
NOWHERE = -1e300


@jit
def advance(medium, tube, state, walls, places, scratch, signals, tally, first_tick, events, counts, failed):
    """Advance as `kernels.advance` does, with ends that move; the cross-section is one number, and stays.

    Args:
        medium: the gas and the numbers of the scheme, its cell size of no weight.
        tube: the constant tables.
        state: what changes.
        walls: of the ends, shape (WALLS,).
        places: where the front passed each cell, shape (n,) [m].
        scratch: memory.
        signals: the means of the inputs over each tick, shape (ticks, SIGNALS).
        tally: shape (TALLY,).
        first_tick: before the first of these ticks.
        events: room for further rows.
        counts: rows of events in use, shape (1,).
        failed: of a failure the cell and the tick, shape (2,).
    """
    n, step = state.density.size, medium.step_size
    for row in range(signals.shape[0]):
        tick = first_tick + row + 1
        failed[1] = tick
        velocities = (signals[row, LEFT_VELOCITY], signals[row, RIGHT_VELOCITY])
        before = (walls[RIGHT] - walls[LEFT]) / n
        motion = (velocities[0], (velocities[1] - velocities[0]) / n)
        status = refuse_long_tick(medium, state, motion, before, failed)
        if status != 0:
            return status
        walls[LEFT] += step * velocities[0]
        walls[RIGHT] += step * velocities[1]
        after = (walls[RIGHT] - walls[LEFT]) / n
        status = flow(
            medium, tube, state, walls, scratch, signals[row], velocities, (before, after), tally, tick, events, counts, failed
        )
        if status != 0:
            return status
        now = Medium(
            medium.gamma, medium.gas_constant, medium.heat, after, step, medium.limiter, medium.law, medium.outside_temperature
        )
        add_heat(now, tube, state, signals[row, POWER], tally)
        status = finish(now, tube, state, motion, tally, tick, events, counts, failed)
        if status != 0:
            return status
        for i in range(n):
            if state.arrival[i] >= 0.0 and places[i] == NOWHERE:
                places[i] = walls[LEFT] + (i + 0.5) * after
    return 0


@internal
def refuse_long_tick(medium, state, motion, size, failed):
    """Return a status where waves cross a cell too fast, as seen from the cell, or the ends would meet; otherwise 0.

    The cell that failed is then the one whose waves are the fastest, so that a step that suits it suits all.
    """
    step, fastest, fits = medium.step_size, 0.0, True
    allowed = LARGEST_COURANT * size / step
    for i in range(state.density.size):
        relative = state.velocity[i] - (motion[0] + (i + 0.5) * motion[1])
        speed = abs(relative) + sqrt(medium.gamma * state.pressure[i] / state.density[i])
        if not speed <= fastest:
            fastest, failed[0] = speed, i
        if not speed <= allowed:
            fits = False
    if not fits:
        return TOO_FAST_AHEAD
    return 0 if size + step * motion[1] > 0.5 * size else ENDS_TOO_FAST


@internal
def flow(medium, tube, state, walls, scratch, signals, velocities, sizes, tally, tick, events, counts, failed):
    """Move gas and faces by one step of Heun, as `kernels.flow` does; return 0 or a status.

    Args:
        medium: this and the following four as of `advance`.
        tube: the constant tables.
        state: what changes.
        walls: of the ends.
        scratch: memory.
        signals: the inputs of the tick.
        velocities: of the two ends [m/s].
        sizes: of a cell before and after the tick [m].
        tally: this and the following four as of `advance`.
        tick: the one that is made.
        events: room for further rows.
        counts: rows of events in use.
        failed: of a failure the cell and the tick.
    """
    n = state.density.size
    before, after = sizes
    step, gamma = medium.step_size, medium.gamma
    for i in range(n):
        scratch.density[i + 1] = state.density[i]
        scratch.velocity[i + 1] = state.velocity[i]
        scratch.pressure[i + 1] = state.pressure[i]
        scratch.fraction[i + 1] = state.fuel[i] / state.density[i]
    walls[LEFT_WALL_PRESSURE] = walls[RIGHT_WALL_PRESSURE] = 0.0
    compute_fluxes(medium, tube, state, walls, scratch, signals, velocities, tick, events, counts)
    tally_ends(medium, state, scratch, tally)
    first, fluxes = scratch.first, scratch.fluxes
    for i in range(n):
        first[0, i] = (before * state.density[i] - step * (fluxes[0, i + 1] - fluxes[0, i])) / after
        first[1, i] = (before * state.momentum[i] - step * (fluxes[1, i + 1] - fluxes[1, i])) / after
        first[2, i] = (before * state.energy[i] - step * (fluxes[2, i + 1] - fluxes[2, i])) / after
        first[3, i] = (before * state.fuel[i] - step * (fluxes[3, i + 1] - fluxes[3, i])) / after
        r = first[0, i]
        u = first[1, i] / r
        p = (gamma - 1.0) * (first[2, i] - 0.5 * first[1, i] * u - first[3, i] * medium.heat)
        scratch.density[i + 1], scratch.velocity[i + 1], scratch.pressure[i + 1] = r, u, p
        scratch.fraction[i + 1] = first[3, i] / r
        if not (r > 0.0 and p > 0.0):
            failed[0], state.density[i], state.pressure[i] = i, r, p
            return NOT_POSITIVE
    compute_fluxes(medium, tube, state, walls, scratch, signals, velocities, tick, events, counts)
    tally_ends(medium, state, scratch, tally)
    half = 0.5 / after
    for i in range(n):
        state.density[i] = half * (before * state.density[i] + (after * first[0, i] - step * (fluxes[0, i + 1] - fluxes[0, i])))
        state.momentum[i] = half * (
            before * state.momentum[i] + (after * first[1, i] - step * (fluxes[1, i + 1] - fluxes[1, i]))
        )
        state.energy[i] = half * (before * state.energy[i] + (after * first[2, i] - step * (fluxes[2, i + 1] - fluxes[2, i])))
        state.fuel[i] = half * (before * state.fuel[i] + (after * first[3, i] - step * (fluxes[3, i + 1] - fluxes[3, i])))
    return 0


@internal
def compute_fluxes(medium, tube, state, walls, scratch, signals, velocities, tick, events, counts):
    """Write the fluxes through all faces as these move, of the stage whose cells are in scratch."""
    n = state.density.size
    fill_ghosts(tube, state, scratch)
    if tube.ends[0] == PISTON:
        scratch.velocity[0] = 2.0 * velocities[0] - scratch.velocity[1]
    if tube.ends[1] == PISTON:
        scratch.velocity[n + 1] = 2.0 * velocities[1] - scratch.velocity[n]
    compute_slopes(medium, scratch)
    density, velocity, pressure, fraction = scratch.density, scratch.velocity, scratch.pressure, scratch.fraction
    dr, du, dp, dy = scratch.slopes[0], scratch.slopes[1], scratch.slopes[2], scratch.slopes[3]
    mass, impulse, energy, fuel = scratch.fluxes[0], scratch.fluxes[1], scratch.fluxes[2], scratch.fluxes[3]
    change = (velocities[1] - velocities[0]) / n
    for i in range(1, n):
        j, w = i + 1, velocities[0] + i * change
        left = (density[i] + dr[i], velocity[i] + du[i] - w, pressure[i] + dp[i], fraction[i] + dy[i])
        right = (density[j] - dr[j], velocity[j] - du[j] - w, pressure[j] - dp[j], fraction[j] - dy[j])
        m, f, e, y = hllc_flux(medium, left, right)
        mass[i], impulse[i], energy[i], fuel[i] = m, f + w * m, e + w * (f + 0.5 * w * m), y
    compute_end_fluxes(medium, tube, state, scratch, signals, tick, events, counts)
    for side in range(2):
        if tube.ends[side] == PISTON:
            i, face, sign, w = (1, 0, -1.0, velocities[0]) if side == 0 else (n, n, 1.0, velocities[1])
            out = sign * (velocity[i] - w) + du[i]
            p = piston_pressure(medium.gamma, density[i] + sign * dr[i], out, pressure[i] + sign * dp[i])
            mass[face], impulse[face], energy[face], fuel[face] = 0.0, p, p * w, 0.0
            walls[LEFT_WALL_PRESSURE + side] += 0.5 * p
