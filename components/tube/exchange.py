"""Exchange between the gas and the shell in a tick: pressures to the stations, area and work back, gas through openings.

The pressure of the gas is taken as linear in each cell (limited, with its mean), and each station has the mean over the part of
the length that belongs to it: the sum of pressure times length over the overlaps of a cell is that of the cell.
"""

from __future__ import annotations

from math import sqrt

from ..detonation.kernel_arrays import WALL_WORK
from ..detonation.limiters import limited_difference
from ..shell.kernels import surface_area
from ..support.jit import internal, jit
from ..support.powers import power

# Entries of the tally since the reset: what has left through openings, and the work of the shell on the room.
LEAKED_MASS, LEAKED_MOMENTUM, LEAKED_ENERGY, ROOM_WORK, TALLY = 0, 1, 2, 3, 4
# Status: a cell has no pressure left.
EMPTIED = 1
# theta of the limiter of `write_pressures`, minmod: no station has more than the largest pressure around it.
_THETA = 1.0


@jit
def overlap_pressure(interface, pressure, overlap):
    """Return the mean pressure of the gas over an overlap [Pa]."""
    i, last = interface.cell[overlap], pressure.size - 1
    back = pressure[i] - pressure[i - 1] if i > 0 else 0.0
    onward = pressure[i + 1] - pressure[i] if i < last else 0.0
    return pressure[i] + interface.offset[overlap] * limited_difference(_THETA, back, onward)


@jit
def write_pressures(interface, pressure, out):
    """Write the pressure of the gas at the stations.

    Args:
        interface: an `Interface`.
        pressure: of the cells, shape (cells,) [Pa].
        out: shape (stations,) [Pa].
    """
    for k in range(out.size):
        force = 0.0
        for overlap in range(interface.begin[k], interface.begin[k + 1]):
            force += interface.length[overlap] * overlap_pressure(interface, pressure, overlap)
        out[k] = force / interface.width[k]


@jit
def write_peaks(pressures, peaks):
    """Raise the peak of each station to its pressure where that is higher."""
    for k in range(peaks.size):
        if pressures[k] > peaks[k]:
            peaks[k] = pressures[k]


@jit
def write_widening(interface, state, out):
    """Write by how much the cross-section at each station is larger than at rest, relatively: of the mean radius squared.

    The mean goes over the nodes on which the gas presses; a station that has lost all of them keeps its value.

    Args:
        interface: an `Interface`.
        state: of the shell.
        out: shape (stations,).
    """
    around = interface.nodes.size // out.size
    for k in range(out.size):
        total, ratio = 0.0, 0.0
        for s in range(k * around, (k + 1) * around):
            if state.area[s, 0] != 0.0 or state.area[s, 1] != 0.0 or state.area[s, 2] != 0.0:
                j, share = interface.nodes[s], interface.share[s]
                y = interface.reference[s, 1] + state.displacement[j, 1]
                z = interface.reference[s, 2] + state.displacement[j, 2]
                total += share
                ratio += share * (sqrt(y * y + z * z) / interface.rest[s])
        if total > 0.0:
            ratio /= total
            out[k] = ratio * ratio - 1.0


@jit
def keep_surface(interface, state, out):
    """Write velocities and areas of the inner surface as they are, shape (2, s, 3)."""
    for s in range(interface.nodes.size):
        j = interface.nodes[s]
        for i in range(3):
            out[0, s, i] = state.velocity[j, i]
            out[1, s, i] = state.area[s, i]


@jit
def add_work(interface, solid, state, before, pressures, room_pressure, works, tally):
    """Add what the gas did on the wall in a step of the shell, and what the wall did on the room.

    Each node sweeps the mean of its areas before and after, times the mean of its velocities: as the shell counts it.

    Args:
        interface: an `Interface`.
        solid: `shell.kernel_arrays.Solid` as it was before the step, when nothing had parted in it.
        state: of the shell, after the step.
        before: velocities [m/s] and areas [m^2] of the inner surface before the step, shape (2, s, 3).
        pressures: of the gas, that acted at the stations, shape (stations,) [Pa].
        room_pressure: on the outer surface [Pa].
        works: of the gas at each station, is added to, shape (stations,) [J].
        tally: shape (TALLY,).
    """
    for s in range(interface.nodes.size):
        j, k, swept = interface.nodes[s], interface.station[s], 0.0
        x, y, z = surface_area(solid.surface, state.displacement, s)
        for i in range(3):
            if solid.body.prescribed[j, i] == 0:
                new = x if i == 0 else (y if i == 1 else z)
                swept += (before[1, s, i] + new) * (before[0, s, i] + state.velocity[j, i])
        swept *= 0.25 * solid.step
        works[k] += pressures[k] * swept
        tally[ROOM_WORK] += room_pressure * swept


@jit
def move_wall(tables, interface, pressures, widening, works, scratch, failed):
    """Give the gas the cross-section that the shell leaves it, and take the work from it that it did on the wall.

    Mass and momentum of each cell stay what they are. Overlaps share the work of their station by pressure and length.

    Args:
        tables: `detonation.kernel_arrays.Tables`.
        interface: an `Interface`.
        pressures: of the gas at the stations now, shape (stations,) [Pa].
        widening: of the stations now, see `write_widening`, shape (stations,).
        works: of the gas at each station in this tick, shape (stations,) [J].
        scratch: shape (2, cells).
        failed: of a failure the cell, shape (1,).

    Returns:
        0, or EMPTIED.
    """
    medium, gas, growth, taken = tables.medium, tables.state, scratch[0], scratch[1]
    growth[:] = 0.0
    taken[:] = 0.0
    for k in range(widening.size):
        part = works[k] / (interface.width[k] * pressures[k])
        for overlap in range(interface.begin[k], interface.begin[k + 1]):
            i, length = interface.cell[overlap], interface.length[overlap]
            growth[i] += length * widening[k]
            taken[i] += part * length * overlap_pressure(interface, gas.pressure, overlap)
    size = medium.cell_size
    for i in range(growth.size):
        old, new = gas.area[i], interface.area[i] * (1.0 + growth[i] / size)
        if new != old or taken[i] != 0.0:
            failed[0] = i
            if not (new > 0.0 and new < 1e300):
                return EMPTIED
            ratio = old / new
            gas.density[i] *= ratio
            gas.momentum[i] *= ratio
            gas.fuel[i] *= ratio
            gas.energy[i] = (gas.energy[i] * old - taken[i] / size) / new
            gas.area[i] = new
            tables.tally[WALL_WORK] -= taken[i]
            if not update_pressure(medium, gas, i):
                return EMPTIED
    return 0


@internal
def update_pressure(medium, gas, i):
    """Write the pressure of a cell from what is conserved; return whether there is any."""
    kinetic = 0.5 * gas.momentum[i] * gas.velocity[i]
    gas.pressure[i] = (medium.gamma - 1.0) * (gas.energy[i] - kinetic - gas.fuel[i] * medium.heat)
    return gas.pressure[i] > 0.0


@internal
def nozzle_flow(gamma, density, pressure, room_pressure):
    """Return the mass flow through an ideal nozzle [kg/(m^2 s)] from gas at rest into a room; 0 where that has more pressure.

    Source: A. H. Shapiro, The Dynamics and Thermodynamics of Compressible Fluid Flow (1953), 4.
    """
    if not pressure > room_pressure:
        return 0.0
    # Behind the narrowest place the flow is as fast as sound where the room has less than the critical pressure.
    root = power(2.0 / (gamma + 1.0), 0.5 * gamma / (gamma - 1.0))
    ratio, critical = room_pressure / pressure, root * root
    ratio = ratio if ratio > critical else critical
    expanded = power(ratio, 1.0 / gamma)
    squared = 2.0 * gamma / (gamma - 1.0) * pressure * density * expanded * expanded * (1.0 - ratio / expanded)
    return sqrt(squared) if squared > 0.0 else 0.0


@jit
def leak(medium, gas, openings, discharge, room_pressure, step, tally):
    """Let gas out through openings in the wall, with its velocity along the tube; nothing flows in.

    What stays behind expands without heat, its pressure going with density^gamma, at most down to the pressure of the room.

    Args:
        medium: `detonation.kernel_arrays.Medium`.
        gas: `detonation.kernel_arrays.State`.
        openings: area of the openings of each cell, shape (cells,) [m^2].
        discharge: mass flow over that of the ideal nozzle.
        room_pressure: outside, 0 in a vacuum [Pa].
        step: length of the tick [s].
        tally: shape (TALLY,).
    """
    gamma = medium.gamma
    for i in range(openings.size):
        if openings[i] > 0.0 and gas.pressure[i] > room_pressure:
            volume, density = gas.area[i] * medium.cell_size, gas.density[i]
            flow = nozzle_flow(gamma, density, gas.pressure[i], room_pressure)
            rate = discharge * openings[i] * flow * step / (density * volume)
            left = 1.0 / (1.0 + rate)
            least = power(room_pressure / gas.pressure[i], 1.0 / gamma) if room_pressure > 0.0 else 0.0
            left = left if left > least else least
            kinetic, chemical = 0.5 * gas.momentum[i] * gas.velocity[i], gas.fuel[i] * medium.heat
            energy = (gas.energy[i] - kinetic - chemical) * power(left, gamma) + (kinetic + chemical) * left
            tally[LEAKED_MASS] += (1.0 - left) * density * volume
            tally[LEAKED_MOMENTUM] += (1.0 - left) * gas.momentum[i] * volume
            tally[LEAKED_ENERGY] += (gas.energy[i] - energy) * volume
            gas.density[i] *= left
            gas.momentum[i] *= left
            gas.fuel[i] *= left
            gas.energy[i] = energy
            update_pressure(medium, gas, i)
