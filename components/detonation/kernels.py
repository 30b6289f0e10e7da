"""The gas over one tick: MUSCL slopes, HLLC fluxes and two stages of Heun; then heat, reaction, and what follows from both.

    (A rho)_t + (A rho u)_x = 0
    (A rho u)_t + (A (rho u^2 + p))_x = p A_x
    (A E)_t + (A u (E + p))_x = -p A_t + heat,    E = p / (gamma - 1) + rho u^2 / 2 + rho Y q
    (A rho Y)_t + (A rho u Y)_x = reaction.

Momentum fluxes are taken less the pressure of the cell, so that gas at rest stays at rest to the bit whatever A(x) is. What
crosses a face leaves one cell and enters the other: mass, energy and momentum are conserved to rounding.
"""

from __future__ import annotations

from math import nan, sqrt

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
    RIGHT_PRESSURE,
    RIGHT_REACHED,
    TOO_FAST,
    UNKNOWN_REACTION,
    WALL_IMPULSE,
    WALL_WORK,
)  # fmt: skip
from .limiters import limited_difference
from .reactions.arrhenius import burn_by_arrhenius
from .reactions.constant_volume import burn_at_constant_volume
from .reactions.pressure_burn import burn_by_pressure
from .reactions.reaction import ARRHENIUS, CONSTANT_VOLUME, INERT, PRESSURE_BURN

# The largest Courant number (|u| + c) dt / dx at which a tick is made.
LARGEST_COURANT = 0.9
# Kinds of events, in the order of `DetonationTube.event_kinds`, and the progress at which gas counts as burnt.
_OPENED, _END_REACHED, _FRONT_PASSED, _IGNITED = 0, 1, 2, 3
BURNT = 0.5
# Gas of which less than this part reacts in a tick burns in no front: cold gas by Arrhenius' law, and air that has come in.
_LEAST_BURN = 1e-5
# Cells that do not move: velocity of the left end, and by how much a cell is faster than the one before it [m/s].
AT_REST = (0.0, 0.0)


@jit
def advance(medium, tube, state, scratch, signals, areas, tally, first_tick, events, counts, failed):
    """Advance by as many ticks as `signals` has rows; return 0 or a status of `kernel_arrays`.

    Args:
        medium: the gas and the numbers of the scheme; this and the following three are tuples of `kernel_arrays`.
        tube: the constant tables.
        state: what changes.
        scratch: memory.
        signals: the means of the inputs over each tick, shape (ticks, SIGNALS).
        areas: what the area's factor is multiplied by, shape (n,) [m^2].
        tally: shape (TALLY,).
        first_tick: before the first of these ticks.
        events: room for further rows.
        counts: rows of events in use, shape (1,).
        failed: of a failure the cell and the tick, shape (2,).
    """
    for row in range(signals.shape[0]):
        tick = first_tick + row + 1
        failed[1] = tick
        status = change_area(medium, state, areas, signals[row, AREA], tally, failed)
        if status != 0:
            return status
        status = flow(medium, tube, state, scratch, signals[row], tally, tick, events, counts, failed)
        if status != 0:
            return status
        add_heat(medium, tube, state, signals[row, POWER], tally)
        status = finish(medium, tube, state, AT_REST, tally, tick, events, counts, failed)
        if status != 0:
            return status
    return 0


@internal
def change_area(medium, state, areas, factor, tally, failed):
    """Let the walls move to a new area, before the tick, and tally the work that they do; return 0 or a status.

    Each cell is compressed at the mean of its pressures before and after, without flow along the tube.
    """
    area, gamma = state.area, medium.gamma
    half = 0.5 * (gamma - 1.0)
    work = 0.0
    for i in range(area.size):
        new = factor * areas[i]
        old = area[i]
        if new != old:
            if not (new * LARGEST_RATIO >= old and new <= LARGEST_RATIO * old):
                failed[0] = i
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
    tally[WALL_WORK] += work * medium.cell_size
    return 0


@internal
def flow(medium, tube, state, scratch, signals, tally, tick, events, counts, failed):
    """Move the gas by one step of Heun: a whole step, and a second one from there, of which the mean is taken.

    Returns 0, or a status where the first one leaves no gas in a cell, or no pressure.
    """
    n = state.density.size
    for i in range(n):
        scratch.density[i + 1] = state.density[i]
        scratch.velocity[i + 1] = state.velocity[i]
        scratch.pressure[i + 1] = state.pressure[i]
        scratch.fraction[i + 1] = state.fuel[i] / state.density[i]
    compute_fluxes(medium, tube, state, scratch, signals, tick, events, counts)
    tally_ends(medium, state, scratch, tally)
    update_first(medium, state, scratch, tally)
    density, momentum, energy, fuel = scratch.first[0], scratch.first[1], scratch.first[2], scratch.first[3]
    for i in range(n):
        r = density[i]
        u, y = momentum[i] / r, fuel[i] / r
        scratch.density[i + 1] = r
        scratch.velocity[i + 1] = u
        scratch.fraction[i + 1] = y
        p = (medium.gamma - 1.0) * (energy[i] - 0.5 * momentum[i] * u - fuel[i] * medium.heat)
        scratch.pressure[i + 1] = p
        if not (r > 0.0 and p > 0.0):
            failed[0], state.density[i], state.pressure[i] = i, r, p
            return NOT_POSITIVE
    compute_fluxes(medium, tube, state, scratch, signals, tick, events, counts)
    tally_ends(medium, state, scratch, tally)
    update_second(medium, state, scratch, tally)
    return 0


@internal
def compute_fluxes(medium, tube, state, scratch, signals, tick, events, counts):
    """Write the fluxes through all faces, of the stage whose cells are in scratch."""
    n = state.density.size
    fill_ghosts(tube, state, scratch)
    compute_slopes(medium, scratch)
    density, velocity, pressure, fraction = scratch.density, scratch.velocity, scratch.pressure, scratch.fraction
    dr, du, dp, dy = scratch.slopes[0], scratch.slopes[1], scratch.slopes[2], scratch.slopes[3]
    mass, impulse, energy, fuel = scratch.fluxes[0], scratch.fluxes[1], scratch.fluxes[2], scratch.fluxes[3]
    for i in range(1, n):
        j = i + 1
        left = (density[i] + dr[i], velocity[i] + du[i], pressure[i] + dp[i], fraction[i] + dy[i])
        right = (density[j] - dr[j], velocity[j] - du[j], pressure[j] - dp[j], fraction[j] - dy[j])
        mass[i], impulse[i], energy[i], fuel[i] = hllc_flux(medium, left, right)
    compute_end_fluxes(medium, tube, state, scratch, signals, tick, events, counts)


@internal
def compute_slopes(medium, scratch):
    """Write the limited differences over half a cell."""
    for row in range(4):
        values = scratch.density
        if row == 1:
            values = scratch.velocity
        elif row == 2:
            values = scratch.pressure
        elif row == 3:
            values = scratch.fraction
        slopes = scratch.slopes[row]
        for i in range(1, values.size - 1):
            here = values[i]
            slopes[i] = 0.5 * limited_difference(medium.limiter, here - values[i - 1], values[i + 1] - here)


@internal
def compute_end_fluxes(medium, tube, state, scratch, signals, tick, events, counts):
    """Write the fluxes at both ends; a diaphragm on which the pressure is too high opens."""
    n = state.density.size
    density, velocity, pressure, fraction = scratch.density, scratch.velocity, scratch.pressure, scratch.fraction
    dr, du, dp, dy = scratch.slopes[0], scratch.slopes[1], scratch.slopes[2], scratch.slopes[3]
    mass, impulse, energy, fuel = scratch.fluxes[0], scratch.fluxes[1], scratch.fluxes[2], scratch.fluxes[3]
    for side in range(2):
        i, sign = (1, -1.0) if side == 0 else (n, 1.0)
        face = 0 if side == 0 else n
        inner = (
            density[i] + sign * dr[i], velocity[i] + sign * du[i], pressure[i] + sign * dp[i], fraction[i] + sign * dy[i]
        )  # fmt: skip
        outside = signals[LEFT_PRESSURE] if side == 0 else signals[RIGHT_PRESSURE]
        is_open = state.flags[LEFT_OPEN + side] != 0
        found = end_flux(medium, inner, sign, tube.ends[side], is_open, outside)
        if tube.ends[side] == DIAPHRAGM and not is_open and found[1] >= tube.burst[side]:
            state.flags[LEFT_OPEN + side] = 1
            add_event(events, counts, tick, _OPENED, side, found[1], tube.burst[side])
            found = end_flux(medium, inner, sign, tube.ends[side], True, outside)
        mass[face], impulse[face], energy[face], fuel[face] = found


@internal_inlined
def add_event(events, counts, tick, kind, index, value, limit):
    """Append a row to the events."""
    row = counts[0]
    events[row, 0], events[row, 1], events[row, 2], events[row, 3], events[row, 4] = tick, kind, index, value, limit
    counts[0] = row + 1


@internal
def fill_ghosts(tube, state, scratch):
    """Write the ghost cells: the mirror image at a wall, a copy elsewhere."""
    n = state.density.size
    for side in range(2):
        ghost, cell = (0, 1) if side == 0 else (n + 1, n)
        wall = tube.ends[side] != ABSORBING and state.flags[LEFT_OPEN + side] == 0
        scratch.density[ghost] = scratch.density[cell]
        scratch.velocity[ghost] = -scratch.velocity[cell] if wall else scratch.velocity[cell]
        scratch.pressure[ghost] = scratch.pressure[cell]
        scratch.fraction[ghost] = scratch.fraction[cell]


@internal
def tally_ends(medium, state, scratch, tally):
    """Add to the tally what one stage, half a step, lets in at the ends."""
    n = state.density.size
    half = 0.5 * medium.step_size
    for side in range(2):
        sign, area, face = (1.0, state.area[0], 0) if side == 0 else (-1.0, state.area[n - 1], n)
        share = sign * half * area
        tally[MASS + side] += share * scratch.fluxes[0, face]
        tally[IMPULSE + side] += share * scratch.fluxes[1, face]
        tally[ENERGY + side] += share * scratch.fluxes[2, face]


@internal_inlined
def face_areas(area, i):
    """Return the areas of the faces of a cell: means of neighbours, at the ends that of the cell."""
    here = area[i]
    before = area[i - 1] if i > 0 else here
    behind = area[i + 1] if i + 1 < area.size else here
    return 0.5 * (before + here), 0.5 * (here + behind)


@internal_inlined
def losses_of(fluxes, area, pressure, rate, i):
    """Return what a cell loses in a whole step: density, momentum, energy, fuel; and the force of its walls on it."""
    mass, impulse, energy, fuel = fluxes[0], fluxes[1], fluxes[2], fluxes[3]
    before, behind = face_areas(area, i)
    k, p = rate / area[i], pressure[i + 1]
    return (
        k * (behind * mass[i + 1] - before * mass[i]),
        k * (behind * (impulse[i + 1] - p) - before * (impulse[i] - p)),
        k * (behind * energy[i + 1] - before * energy[i]),
        k * (behind * fuel[i + 1] - before * fuel[i]),
        p * (behind - before),
    )


@internal
def update_first(medium, state, scratch, tally):
    """Write what a whole step makes of the state."""
    first, rate, wall = scratch.first, medium.step_size / medium.cell_size, 0.0
    for i in range(state.area.size):
        density, momentum, energy, fuel, force = losses_of(scratch.fluxes, state.area, scratch.pressure, rate, i)
        first[0, i] = state.density[i] - density
        first[1, i] = state.momentum[i] - momentum
        first[2, i] = state.energy[i] - energy
        first[3, i] = state.fuel[i] - fuel
        wall += force
    tally[WALL_IMPULSE] += 0.5 * medium.step_size * wall


@internal
def update_second(medium, state, scratch, tally):
    """Write the mean of the state and of what a second whole step makes of the first."""
    first, rate, wall = scratch.first, medium.step_size / medium.cell_size, 0.0
    for i in range(state.area.size):
        density, momentum, energy, fuel, force = losses_of(scratch.fluxes, state.area, scratch.pressure, rate, i)
        state.density[i] = 0.5 * (state.density[i] + (first[0, i] - density))
        state.momentum[i] = 0.5 * (state.momentum[i] + (first[1, i] - momentum))
        state.energy[i] = 0.5 * (state.energy[i] + (first[2, i] - energy))
        state.fuel[i] = 0.5 * (state.fuel[i] + (first[3, i] - fuel))
        wall += force
    tally[WALL_IMPULSE] += 0.5 * medium.step_size * wall


@internal
def add_heat(medium, tube, state, heat_rate, tally):
    """Heat the ignition zone evenly by a power [W] over the tick."""
    if heat_rate != 0.0:
        first, last = tube.heated[0], tube.heated[1]
        volume = 0.0
        for i in range(first, last):
            volume += state.area[i] * medium.cell_size
        added = medium.step_size * heat_rate / volume
        for i in range(first, last):
            state.energy[i] += added
        tally[IGNITION] += medium.step_size * heat_rate


@internal_inlined
def react(medium, tube, density, pressure, fraction):
    """Return the part that has not reacted after a tick, and the pressure that a law has written over the old one.

    The part is NaN where no kernel knows the law.
    """
    if medium.law == PRESSURE_BURN:
        return burn_by_pressure(tube.reaction, pressure, fraction, medium.step_size), pressure
    if medium.law == ARRHENIUS:
        return burn_by_arrhenius(tube.reaction, density, pressure, fraction, medium.step_size), pressure
    if medium.law == CONSTANT_VOLUME:
        return burn_at_constant_volume(tube.reaction, density, pressure, fraction)
    return nan, pressure


@internal
def finish(medium, tube, state, motion, tally, tick, events, counts, failed):
    """Let the gas react, compute velocity, pressure and progress, note what happened; return 0 or a status.

    Where cells move, as `motion` says, waves are too fast if they are for a cell at rest and for the cell as it moved: how it
    moves next is known at the next tick alone, which begins with a check of its own (`moving_mesh.refuse_long_tick`).
    """
    gamma, heat = medium.gamma, medium.heat
    allowed = LARGEST_COURANT * medium.cell_size / medium.step_size
    overwritten, peak, idle = 0.0, tally[PEAK], tally[IDLE] + 1.0
    for i in range(state.density.size):
        density, energy = state.density[i], state.energy[i]
        velocity, fraction = state.momentum[i] / density, state.fuel[i] / density
        kinetic = 0.5 * state.momentum[i] * velocity
        pressure = (gamma - 1.0) * (energy - kinetic - state.fuel[i] * heat)
        failed[0], burns = i, False
        if not (density > 0.0 and pressure > 0.0 and density < 1e300):
            state.pressure[i] = pressure
            return NOT_POSITIVE
        if medium.law != INERT and fraction > 0.0:
            peak = pressure if pressure > peak else peak
            new, written = react(medium, tube, density, pressure, fraction)
            if not new >= 0.0:
                return UNKNOWN_REACTION
            if new != fraction:
                burns = fraction - new > _LEAST_BURN
                fraction = new
                state.fuel[i] = density * new
                if written != pressure:
                    wanted = written / (gamma - 1.0) + kinetic + state.fuel[i] * heat
                    overwritten += (wanted - energy) * state.area[i]
                    state.energy[i] = energy = wanted
                pressure = (gamma - 1.0) * (energy - kinetic - state.fuel[i] * heat)
                if not pressure > 0.0:  # a law that turns burnt gas into fresh gas takes heat
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
            note_front(tube, state, i, progress, tick, events, counts)
        if burns and state.flags[IGNITED]:
            idle = 0.0
    tally[OVERWRITTEN] += overwritten * medium.cell_size
    tally[PEAK], tally[IDLE] = peak, idle
    return 0


@internal
def note_front(tube, state, cell, progress, tick, events, counts):
    """Note that a front has passed a cell: the first that burns, a gauge, an end."""
    flags, last = state.flags, state.density.size - 1
    starts = flags[IGNITED] == 0
    if starts:
        flags[IGNITED] = 1
        add_event(events, counts, tick, _IGNITED, cell, progress, BURNT)
    if tube.gauges[cell] >= 0:
        add_event(events, counts, tick, _FRONT_PASSED, tube.gauges[cell], progress, BURNT)
    if cell == 0 and not starts and flags[LEFT_REACHED] == 0:
        flags[LEFT_REACHED] = 1
        add_event(events, counts, tick, _END_REACHED, 0, progress, BURNT)
    if cell == last and not starts and flags[RIGHT_REACHED] == 0:
        flags[RIGHT_REACHED] = 1
        add_event(events, counts, tick, _END_REACHED, 1, progress, BURNT)
