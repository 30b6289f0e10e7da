"""Exchange between gas and shell: pressures on the stations, area and work for the gas, leaks through openings.

The pressure of the gas is linear in each cell, with limited slopes and exact cell means. Each station gets the mean pressure
over its section. The sum of pressure times length over the overlaps of a cell equals that of the cell.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..detonation.kernel_arrays import WALL_WORK
from ..detonation.kernel_arrays import Tables as GasTables
from ..shell.kernel_arrays import State, Tables
from ..support.float_arrays import FloatArray, ordered_sum_of_rows
from ..support.jit import internal, jit
from ..support.powers import power
from .interface_overlaps import Interface, Overlaps

# Entries of the tally, i.e. sums since the reset: leaked mass, momentum and energy, and the work of the shell on the room.
LEAKED_MASS, LEAKED_MOMENTUM, LEAKED_ENERGY, ROOM_WORK, TALLY = 0, 1, 2, 3, 4


def overlap_pressures(overlaps: Overlaps, pressure: FloatArray) -> FloatArray:
    """Return the mean pressure of the gas over each overlap, shape (overlaps,) [Pa].

    Slopes are limited (minmod): no overlap exceeds the largest pressure of the neighbouring cells.
    """
    i, last = overlaps.cell, len(pressure) - 1
    back = np.where(i > 0, pressure[i] - pressure[np.maximum(i - 1, 0)], 0.0)
    onward = np.where(i < last, pressure[np.minimum(i + 1, last)] - pressure[i], 0.0)
    least = np.minimum(np.abs(back), np.abs(onward))
    slope = np.where(back * onward > 0.0, np.copysign(least, back), 0.0)
    return pressure[i] + overlaps.offset * slope


def station_pressures(interface: Interface, pressure: FloatArray) -> FloatArray:
    """Return the pressures at the stations, shape (stations,), from the cell pressures, shape (cells,) [Pa]."""
    return interface.to_stations(interface.overlaps.length * overlap_pressures(interface.overlaps, pressure)) / interface.width


def write_widening(interface: Interface, state: State, out: FloatArray) -> None:
    """Write the relative growth of the cross-section at each station, i.e. of the square of the mean radius.

    The mean is over nodes that the gas loads; a station that has lost all these nodes keeps its value.

    Args:
        interface: the nodes of the stations.
        state: state of the shell.
        out: the growth, shape (stations,); written.
    """
    y, z = (interface.reference + state.displacement[interface.nodes]).T[1:]
    share = np.where((state.area != 0.0).any(axis=1), interface.share, 0.0)
    shares = np.stack([share, share * (np.sqrt(y * y + z * z) / interface.rest)])
    # The nodes around each station are summed in a fixed order.
    total, radius = ordered_sum_of_rows(shares.reshape(2, len(out), -1).transpose(2, 0, 1))
    some = total > 0.0
    ratio = radius[some] / total[some]
    out[some] = ratio * ratio - 1.0


def swept_volumes(tables: Tables, area: FloatArray) -> FloatArray:
    """Return the volume swept by each node of the inner surface in a step of the shell, shape (s,) [m^3].

    It is the mean of the areas before and after times the mean of the velocities, as in the work of the shell.

    Args:
        tables: tables of the shell after the step.
        area: area vectors of the nodes before the step, shape (s, 3) [m^2].
    """
    solid, state, scratch, _ = tables
    nodes = solid.surface.nodes
    swept = (area + scratch.area) * (scratch.before + state.velocity[nodes])
    free = np.where(solid.nodes.prescribed[nodes] == 0, swept, 0.0)
    return ordered_sum_of_rows(free.T) * (0.25 * solid.step)


@np.errstate(all="ignore")
def move_wall(gas: GasTables, interface: Interface, pressures: FloatArray, widening: FloatArray, works: FloatArray) -> int:
    """Set the cross-section of the gas to the present one of the shell, and subtract the work of the gas on the wall.

    Mass and momentum of each cell do not change. Overlaps share the work of their station by pressure and length.

    Args:
        gas: tables of the gas.
        interface: the overlaps.
        pressures: present gas pressures at the stations, shape (stations,) [Pa].
        widening: present growth at the stations, see `write_widening`, shape (stations,).
        works: work of the gas at each station in this tick, shape (stations,) [J].

    Returns:
        -1, or the first cell without pressure left.
    """
    medium, state, size, overlaps = gas.medium, gas.state, gas.medium.cell_size, interface.overlaps
    part = (works / (interface.width * pressures))[overlaps.station]
    growth = interface.to_cells(overlaps.length * widening[overlaps.station])
    taken = interface.to_cells(part * overlaps.length * overlap_pressures(overlaps, state.pressure))
    new = interface.area * (1.0 + growth / size)
    changed = np.flatnonzero((new != state.area) | (taken != 0.0))
    old, new, taken = state.area[changed], new[changed], taken[changed]
    ratio = old / new
    for conserved in (state.density, state.momentum, state.fuel):
        conserved[changed] *= ratio
    state.energy[changed] = (state.energy[changed] * old - taken / size) / new
    state.area[changed] = new
    gas.tally[WALL_WORK] = np.subtract.accumulate(np.concatenate([gas.tally[WALL_WORK : WALL_WORK + 1], taken]))[-1]
    kinetic = 0.5 * state.momentum[changed] * state.velocity[changed]
    pressure = (medium.gamma - 1.0) * (state.energy[changed] - kinetic - state.fuel[changed] * medium.heat)
    state.pressure[changed] = pressure
    empty = changed[~((new > 0.0) & (new < 1e300) & (pressure > 0.0))]
    return int(empty[0]) if len(empty) else -1


@internal
def nozzle_flow(gamma, density, pressure, room_pressure):
    """Return the mass flow through an ideal nozzle from gas at rest into a room [kg/(m^2 s)]; 0 if the room pressure is higher.

    Source: A. H. Shapiro, The Dynamics and Thermodynamics of Compressible Fluid Flow (1953), 4.
    """
    if not pressure > room_pressure:
        return 0.0
    # The flow is sonic at the throat if the room pressure is below the critical pressure.
    root = power(2.0 / (gamma + 1.0), 0.5 * gamma / (gamma - 1.0))
    ratio, critical = room_pressure / pressure, root * root
    ratio = ratio if ratio > critical else critical
    expanded = power(ratio, 1.0 / gamma)
    squared = 2.0 * gamma / (gamma - 1.0) * pressure * density * expanded * expanded * (1.0 - ratio / expanded)
    return sqrt(squared) if squared > 0.0 else 0.0


@jit
def leak_gas(medium, gas, openings, discharge, room_pressure, step, tally):
    """Let gas leak through openings in the wall, with its velocity along the tube; there is no inflow.

    The remaining gas expands adiabatically, with pressure proportional to density^gamma, at most down to the room pressure.

    Args:
        medium: `detonation.kernel_arrays.Medium`.
        gas: `detonation.kernel_arrays.State`.
        openings: area of the openings of each cell, shape (cells,) [m^2].
        discharge: mass flow divided by that of the ideal nozzle.
        room_pressure: pressure outside, 0 in a vacuum [Pa].
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
            kinetic = 0.5 * gas.momentum[i] * gas.velocity[i]
            gas.pressure[i] = (gamma - 1.0) * (energy - kinetic - gas.fuel[i] * medium.heat)
