"""One tick of the gas: MUSCL slopes, HLLC fluxes and the two stages of Heun's method; then heat, reaction and derived state.

    (A rho)_t + (A rho u)_x = 0
    (A rho u)_t + (A (rho u^2 + p))_x = p A_x
    (A E)_t + (A u (E + p))_x = -p A_t + heat,    E = p / (gamma - 1) + rho u^2 / 2 + rho Y q
    (A rho Y)_t + (A rho u Y)_x = reaction.

Momentum fluxes are taken relative to the pressure of the cell, so that gas at rest stays at rest, bitwise, for any A(x). The
flux through a face leaves one cell and enters the other: mass, energy and momentum are conserved to rounding.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from ..support.jit import internal, internal_inlined, jit
from .boundaries import ABSORBING, DIAPHRAGM
from .fluxes import end_flux, hllc_flux
from .kernel_arrays import (
    AREA,
    BAD_AREA,
    ENERGY,
    IDLE,
    IGNITED,
    IGNITION,
    IMPULSE,
    LARGEST_RATIO,
    LEFT_OPEN,
    LEFT_PRESSURE,
    LEFT_REACHED,
    MASS,
    NOT_POSITIVE,
    OVERWRITTEN,
    PEAK,
    POWER,
    RIGHT_REACHED,
    TOO_FAST,
    WALL_IMPULSE,
    WALL_WORK,
)  # fmt: skip
from .limiters import limited_difference
from .reactions.reaction import advance_reaction

# Largest Courant number (|u| + c) dt / dx that a tick accepts.
LARGEST_COURANT = 0.9
# Kinds of events, in the order of `DetonationTube.event_kinds`, and the progress from which gas counts as burnt.
_OPENED, _END_REACHED, _FRONT_PASSED, _IGNITED = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
BURNT = 0.5
# If a smaller fraction of a cell reacts in a tick, the cell is not in a front: cold gas with Arrhenius' law, air from outside.
_LEAST_BURN = 1e-5
# Motion of a fixed mesh: velocity of the left end, and the increase of velocity from cell to cell [m/s].
AT_REST = (0.0, 0.0)


@jit
def advance(tables, signals, areas, first_tick, events, failure):
    """Advance by one tick per row of `signals`; return 0 or a status of `kernel_arrays`.

    Args:
        tables: `kernel_arrays.Tables`, whose state and tally are updated.
        signals: means of the inputs over each tick, shape (ticks, SIGNALS).
        areas: cross-sections, to be multiplied by the factor in `signals`, shape (n,) [m^2].
        first_tick: number at the beginning of the first of these ticks.
        events: `kernel_arrays.Events`, updated.
        failure: cell and tick of a failure, shape (2,).
    """
    for row in range(signals.shape[0]):
        tick = first_tick + row + 1
        failure[1] = tick
        status = change_area(tables, areas, signals[row, AREA], failure)
        if status != 0:
            return status
        status = heun_step(tables, signals[row], tick, events, failure)
        if status != 0:
            return status
        add_heat(tables, signals[row, POWER])
        status = finish_tick(tables, AT_REST, tick, events, failure)
        if status != 0:
            return status
    return 0


@internal
def change_area(tables, areas, factor, failure):
    """Move the walls to a new area before the tick, and tally their work; return 0 or a status.

    Each cell is compressed at the mean of its pressures before and after, without flow along the tube.
    """
    state, gamma = tables.state, tables.medium.gamma
    area = state.area
    half = 0.5 * (gamma - 1.0)
    work = 0.0
    for i in range(area.size):
        new = factor * areas[i]
        old = area[i]
        if new != old:
            if not (new * LARGEST_RATIO >= old and new <= LARGEST_RATIO * old):
                failure[0] = i
                return BAD_AREA
            change, before = new - old, state.pressure[i]
            after = before * (old - half * change) / (new + half * change)
            ratio = old / new
            state.density[i] *= ratio
            state.momentum[i] *= ratio
            state.fuel[i] *= ratio
            state.energy[i] = (state.energy[i] * old - 0.5 * (before + after) * change) / new
            state.pressure[i] = after
            area[i] = new
            work -= 0.5 * (before + after) * change
    tables.tally[WALL_WORK] += work * tables.medium.cell_size
    return 0


@internal
def write_start_stage(state, stage):
    """Write density, velocity, pressure and unreacted fraction of each cell to `stage`, from which fluxes are computed."""
    for i in range(state.density.size):
        stage[0, i + 1] = state.density[i]
        stage[1, i + 1] = state.velocity[i]
        stage[2, i + 1] = state.pressure[i]
        stage[3, i + 1] = state.fuel[i] / state.density[i]


@internal
def write_heun_stage(tables, failure):
    """Write the stage after the first Heun step; return 0, or a status if a density or pressure is not positive."""
    medium, state, stage, first = tables.medium, tables.state, tables.scratch.stage, tables.scratch.first
    for i in range(state.density.size):
        r, momentum, energy, fuel = first[0, i], first[1, i], first[2, i], first[3, i]
        u = momentum / r
        p = (medium.gamma - 1.0) * (energy - 0.5 * momentum * u - fuel * medium.heat)
        stage[0, i + 1], stage[1, i + 1], stage[2, i + 1], stage[3, i + 1] = r, u, p, fuel / r
        if not (r > 0.0 and p > 0.0):
            failure[0], state.density[i], state.pressure[i] = i, r, p
            return NOT_POSITIVE
    return 0


@internal
def heun_step(tables, signals, tick, events, failure):
    """Advance the gas by one step of Heun's method: the mean of the state and of the result of two whole steps.

    Returns 0, or a status if the first step leaves a density or pressure that is not positive.
    """
    write_start_stage(tables.state, tables.scratch.stage)
    compute_fluxes(tables, signals, tick, events)
    tally_end_flows(tables)
    write_first_step(tables)
    status = write_heun_stage(tables, failure)
    if status != 0:
        return status
    compute_fluxes(tables, signals, tick, events)
    tally_end_flows(tables)
    write_second_step(tables)
    return 0


@internal
def compute_fluxes(tables, signals, tick, events):
    """Write the fluxes through all faces, for the stage in scratch."""
    medium, scratch = tables.medium, tables.scratch
    fill_ghost_cells(tables)
    compute_slopes(medium.limiter, scratch)
    density, velocity, pressure, fraction = scratch.stage[0], scratch.stage[1], scratch.stage[2], scratch.stage[3]
    dr, du, dp, dy = scratch.slopes[0], scratch.slopes[1], scratch.slopes[2], scratch.slopes[3]
    mass, impulse, energy, fuel = scratch.fluxes[0], scratch.fluxes[1], scratch.fluxes[2], scratch.fluxes[3]
    for i in range(1, tables.state.density.size):
        j = i + 1
        left = (density[i] + dr[i], velocity[i] + du[i], pressure[i] + dp[i], fraction[i] + dy[i])
        right = (density[j] - dr[j], velocity[j] - du[j], pressure[j] - dp[j], fraction[j] - dy[j])
        mass[i], impulse[i], energy[i], fuel[i] = hllc_flux(medium, left, right)
    compute_end_fluxes(tables, signals, tick, events)


@internal
def compute_slopes(limiter, scratch):
    """Write the limited differences, over half a cell, of density, velocity, pressure and unreacted fraction."""
    for row in range(4):
        values, slopes = scratch.stage[row], scratch.slopes[row]
        for i in range(1, values.size - 1):
            here = values[i]
            slopes[i] = 0.5 * limited_difference(limiter, here - values[i - 1], values[i + 1] - here)


@internal
def compute_end_fluxes(tables, signals, tick, events):
    """Write the fluxes at both ends; a diaphragm opens if the pressure on it reaches its bursting pressure."""
    medium, tube, state, scratch = tables.medium, tables.tube, tables.state, tables.scratch
    n, stage, slopes = state.density.size, scratch.stage, scratch.slopes
    for side in range(2):
        i, face, sign = (1, 0, -1.0) if side == 0 else (n, n, 1.0)
        inner = (
            stage[0, i] + sign * slopes[0, i], stage[1, i] + sign * slopes[1, i], stage[2, i] + sign * slopes[2, i],
            stage[3, i] + sign * slopes[3, i],
        )  # fmt: skip
        outside = signals[LEFT_PRESSURE + side]
        is_open = state.flags[LEFT_OPEN + side] != 0
        found = end_flux(medium, inner, sign, tube.ends[side], is_open, outside)
        if tube.ends[side] == DIAPHRAGM and not is_open and found[1] >= tube.burst[side]:
            state.flags[LEFT_OPEN + side] = 1
            add_event(events, tick, _OPENED, side, found[1], tube.burst[side])
            is_open = state.flags[LEFT_OPEN + side] != 0
            found = end_flux(medium, inner, sign, tube.ends[side], is_open, outside)
        fluxes = scratch.fluxes
        fluxes[0, face], fluxes[1, face], fluxes[2, face], fluxes[3, face] = found


@internal
def add_event(events, tick, kind, index, value, limit):
    """Append a row to the events."""
    rows, row = events.rows, events.used[0]
    rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3], rows[row, 4] = tick, kind, index, value, limit
    events.used[0] = row + 1


@internal
def fill_ghost_cells(tables):
    """Write the ghost cells: the mirror image at a wall, a copy elsewhere."""
    state, stage = tables.state, tables.scratch.stage
    n = state.density.size
    for side in range(2):
        ghost, cell = (0, 1) if side == 0 else (n + 1, n)
        wall = tables.tube.ends[side] != ABSORBING and state.flags[LEFT_OPEN + side] == 0
        stage[0, ghost], stage[2, ghost], stage[3, ghost] = stage[0, cell], stage[2, cell], stage[3, cell]
        stage[1, ghost] = -stage[1, cell] if wall else stage[1, cell]


@internal
def tally_end_flows(tables):
    """Add to the tally the mass, momentum and energy that enter at the ends in one stage, weighted as half a step."""
    state, fluxes, tally = tables.state, tables.scratch.fluxes, tables.tally
    n = state.density.size
    half = 0.5 * tables.medium.step_size
    for side in range(2):
        sign, area, face = (1.0, state.area[0], 0) if side == 0 else (-1.0, state.area[n - 1], n)
        share = sign * half * area
        tally[MASS + side] += share * fluxes[0, face]
        tally[IMPULSE + side] += share * fluxes[1, face]
        tally[ENERGY + side] += share * fluxes[2, face]


@internal_inlined
def face_areas(area, i):
    """Return the areas of the faces of a cell: means of neighbouring cells, at the ends the area of the cell."""
    here = area[i]
    before = area[i - 1] if i > 0 else here
    behind = area[i + 1] if i + 1 < area.size else here
    return 0.5 * (before + here), 0.5 * (here + behind)


class Losses(NamedTuple):
    """Net outflow of a cell in a whole step, per volume, and the force of its walls on the gas [N]."""

    density: float
    momentum: float
    energy: float
    fuel: float
    wall_force: float


@internal_inlined
def cell_losses(fluxes, area, pressure, rate, i):
    """Return the `Losses` of a cell; `rate` is the step over the length of a cell [s/m]."""
    mass, impulse, energy, fuel = fluxes[0], fluxes[1], fluxes[2], fluxes[3]
    before, behind = face_areas(area, i)
    k, p = rate / area[i], pressure[i + 1]
    return Losses(
        k * (behind * mass[i + 1] - before * mass[i]),
        k * (behind * (impulse[i + 1] - p) - before * (impulse[i] - p)),
        k * (behind * energy[i + 1] - before * energy[i]),
        k * (behind * fuel[i + 1] - before * fuel[i]),
        p * (behind - before),
    )


@internal
def write_first_step(tables):
    """Write the conserved quantities after the first Euler step of Heun's method to `first`."""
    medium, state, scratch = tables.medium, tables.state, tables.scratch
    first, rate, wall = scratch.first, medium.step_size / medium.cell_size, 0.0
    for i in range(state.area.size):
        lost = cell_losses(scratch.fluxes, state.area, scratch.stage[2], rate, i)
        first[0, i] = state.density[i] - lost.density
        first[1, i] = state.momentum[i] - lost.momentum
        first[2, i] = state.energy[i] - lost.energy
        first[3, i] = state.fuel[i] - lost.fuel
        wall += lost.wall_force
    tables.tally[WALL_IMPULSE] += 0.5 * medium.step_size * wall


@internal
def write_second_step(tables):
    """Write the new state: the mean of the old one and of the result of a second Euler step, which begins at `first`."""
    medium, state, scratch = tables.medium, tables.state, tables.scratch
    first, rate, wall = scratch.first, medium.step_size / medium.cell_size, 0.0
    for i in range(state.area.size):
        lost = cell_losses(scratch.fluxes, state.area, scratch.stage[2], rate, i)
        state.density[i] = 0.5 * (state.density[i] + (first[0, i] - lost.density))
        state.momentum[i] = 0.5 * (state.momentum[i] + (first[1, i] - lost.momentum))
        state.energy[i] = 0.5 * (state.energy[i] + (first[2, i] - lost.energy))
        state.fuel[i] = 0.5 * (state.fuel[i] + (first[3, i] - lost.fuel))
        wall += lost.wall_force
    tables.tally[WALL_IMPULSE] += 0.5 * medium.step_size * wall


@internal
def add_heat(tables, heat_rate):
    """Heat the ignition zone evenly by a power [W] over the tick."""
    medium, state, tube = tables.medium, tables.state, tables.tube
    if heat_rate != 0.0:
        first, last = tube.heated[0], tube.heated[1]
        volume = 0.0
        for i in range(first, last):
            volume += state.area[i] * medium.cell_size
        added = medium.step_size * heat_rate / volume
        for i in range(first, last):
            state.energy[i] += added
        tables.tally[IGNITION] += medium.step_size * heat_rate


@internal
def finish_tick(tables, motion, tick, events, failure):
    """Let the gas react, compute velocity, pressure and progress, and record events; return 0 or a status.

    If the cells move, given by `motion`, waves are too fast only if they are too fast both for a cell at rest and for the
    moving cell. The next motion is unknown here; the next tick begins with its own check (`moving_mesh.refuse_long_tick`).
    """
    medium, state, tally, law = tables.medium, tables.state, tables.tally, tables.tube.reaction
    gamma, heat = medium.gamma, medium.heat
    allowed = LARGEST_COURANT * medium.cell_size / medium.step_size
    overwritten, peak, idle = 0.0, tally[PEAK], tally[IDLE] + 1.0
    for i in range(state.density.size):
        density, energy = state.density[i], state.energy[i]
        velocity, fraction = state.momentum[i] / density, state.fuel[i] / density
        kinetic = 0.5 * state.momentum[i] * velocity
        pressure = (gamma - 1.0) * (energy - kinetic - state.fuel[i] * heat)
        failure[0], burns = i, False
        if not (density > 0.0 and pressure > 0.0 and density < 1e300):
            state.pressure[i] = pressure
            return NOT_POSITIVE
        if heat > 0.0 and fraction > 0.0:
            peak = pressure if pressure > peak else peak
            new, written = advance_reaction(law, density, pressure, fraction, medium.step_size)
            if new != fraction:
                burns = fraction - new > _LEAST_BURN
                fraction = new
                state.fuel[i] = density * new
                if written != pressure:
                    wanted = written / (gamma - 1.0) + kinetic + state.fuel[i] * heat
                    overwritten += (wanted - energy) * state.area[i]
                    state.energy[i] = energy = wanted
                pressure = (gamma - 1.0) * (energy - kinetic - state.fuel[i] * heat)
                if not pressure > 0.0:  # a law that turns burnt into fresh gas absorbs heat
                    state.pressure[i] = pressure
                    return NOT_POSITIVE
        progress = 1.0 - fraction
        progress = 0.0 if progress < 0.0 else (1.0 if progress > 1.0 else progress)
        old, state.progress[i] = state.progress[i], progress
        state.velocity[i], state.pressure[i] = velocity, pressure
        sound = sqrt(gamma * pressure / density)
        if not abs(velocity) + sound <= allowed:
            if not abs(velocity - (motion[0] + (i + 0.5) * motion[1])) + sound <= allowed:
                return TOO_FAST
        if burns and progress >= BURNT and state.arrival[i] < 0.0:
            part = (BURNT - old) / (progress - old) if old < BURNT else 0.0
            state.arrival[i] = (tick - 1 + part) * medium.step_size
            record_front(tables.tube, state, i, progress, tick, events)
        if burns and state.flags[IGNITED]:
            idle = 0.0
    tally[OVERWRITTEN] += overwritten * medium.cell_size
    tally[PEAK], tally[IDLE] = peak, idle
    return 0


@internal
def record_front(tube, state, cell, progress, tick, events):
    """Record the front's passage through a cell: first ignition, a gauge, an end."""
    flags, last = state.flags, state.density.size - 1
    starts = flags[IGNITED] == 0
    if starts:
        flags[IGNITED] = 1
        add_event(events, tick, _IGNITED, cell, progress, BURNT)
    if tube.gauges[cell] >= 0:
        add_event(events, tick, _FRONT_PASSED, tube.gauges[cell], progress, BURNT)
    if cell == 0 and not starts and flags[LEFT_REACHED] == 0:
        flags[LEFT_REACHED] = 1
        add_event(events, tick, _END_REACHED, np.int64(0), progress, BURNT)
    if cell == last and not starts and flags[RIGHT_REACHED] == 0:
        flags[RIGHT_REACHED] = 1
        add_event(events, tick, _END_REACHED, np.int64(1), progress, BURNT)
