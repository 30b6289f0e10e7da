"""Tuples of arrays and numbers for kernels: the gas, the tube, the state, and scratch.

The mesh has n cells of equal length. Conserved quantities are stored per volume of gas. Derived quantities that the next tick
needs are stored with them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]


class Medium(NamedTuple):
    """Constants of the gas and of the scheme.

    Attributes:
        gamma: adiabatic exponent.
        gas_constant: p / (rho T) [J/(kg K)].
        heat: heat of the complete reaction [J/kg].
        cell_size: length of a cell [m].
        step_size: length of a tick [s].
        limiter: theta of the slope limiter; see `limiters`.
        outside_temperature: temperature of gas that flows in through open ends [K].
    """

    gamma: float
    gas_constant: float
    heat: float
    cell_size: float
    step_size: float
    limiter: float
    outside_temperature: float


class State(NamedTuple):
    """The changing arrays, all at the same tick.

    Attributes:
        density: shape (n,) [kg/m^3].
        momentum: per volume, shape (n,) [kg/(m^2 s)].
        energy: thermal, kinetic and chemical, per volume, shape (n,) [J/m^3].
        fuel: unreacted mass, per volume, shape (n,) [kg/m^3].
        velocity: shape (n,) [m/s].
        pressure: shape (n,) [Pa].
        progress: reacted fraction of the gas, 0 to 1, shape (n,).
        area: cross-section, shape (n,) [m^2].
        arrival: time at which the progress passed 1/2, or -1 before, shape (n,) [s].
        flags: see `LEFT_OPEN` and the constants after it, shape (FLAGS,).
    """

    density: FloatArray
    momentum: FloatArray
    energy: FloatArray
    fuel: FloatArray
    velocity: FloatArray
    pressure: FloatArray
    progress: FloatArray
    area: FloatArray
    arrival: FloatArray
    flags: IntArray


class Tube(NamedTuple):
    """The constant tables.

    Attributes:
        ends: code of the left and the right end, shape (2,); see `boundaries`.
        burst: pressure at which the diaphragm at each end opens, shape (2,) [Pa].
        reaction: constants of the reaction, a named tuple; see `reactions`.
        heated: first cell of the ignition zone, and the cell after its last one, shape (2,).
        gauges: number of the gauge in each cell, -1 without a gauge, shape (n,).
    """

    ends: IntArray
    burst: FloatArray
    reaction: Any
    heated: IntArray
    gauges: IntArray


class Scratch(NamedTuple):
    """Scratch memory; its contents are not kept between ticks.

    Attributes:
        stage: density, velocity, pressure and unreacted fraction, with a ghost cell at each end, shape (4, n + 2).
        slopes: limited differences of these quantities over half a cell, shape (4, n + 2).
        fluxes: of mass, momentum, energy and fuel through each face, shape (4, n + 1).
        first: density, momentum, energy and fuel after the first stage, shape (4, n).
    """

    stage: FloatArray
    slopes: FloatArray
    fluxes: FloatArray
    first: FloatArray


class Tables(NamedTuple):
    """All arguments of the kernels; `tally` has the entries named below, shape (TALLY,)."""

    medium: Medium
    tube: Tube
    state: State
    scratch: Scratch
    tally: FloatArray


class Events(NamedTuple):
    """Rows of events, with spare rows, and the number of rows in use, shape (1,)."""

    rows: FloatArray
    used: IntArray


# Flags: whether each end is open, whether any gas has burnt, and whether a front has reached each end.
LEFT_OPEN, RIGHT_OPEN, IGNITED, LEFT_REACHED, RIGHT_REACHED, FLAGS = 0, 1, 2, 3, 4, 5
# Entries of the tally (sums since the reset); MASS, IMPULSE and ENERGY have one for the left, then one for the right end. PEAK
# is the largest pressure of unburnt gas, IDLE the number of ticks since ignited gas last burnt, or since the reset.
MASS, IMPULSE, ENERGY, WALL_IMPULSE, WALL_WORK, IGNITION, OVERWRITTEN, PEAK, IDLE, TALLY = 0, 2, 4, 6, 7, 8, 9, 10, 11, 12
# Columns of the signals, the inputs averaged over a tick: power [W], two pressures [Pa], factor of the area, velocities [m/s].
POWER, LEFT_PRESSURE, RIGHT_PRESSURE, AREA, LEFT_VELOCITY, RIGHT_VELOCITY, SIGNALS = 0, 1, 2, 3, 4, 5, 6
# Statuses of a tick. The last two belong to a moving mesh, whose state is then still that before the tick: waves too fast for
# the cells at the end velocities of this tick, and ends that would leave less than half of the tube.
NOT_POSITIVE, TOO_FAST, BAD_AREA, TOO_FAST_AHEAD, ENDS_TOO_FAST = 1, 2, 3, 4, 5
# Largest ratio by which a cross-section may grow or shrink in a tick: the gas pressure is then right within 4 %.
LARGEST_RATIO = 2.0


def make_scratch(cells: int) -> Scratch:
    """Return scratch arrays for `cells` cells."""
    return Scratch(*(np.zeros((4, size)) for size in (cells + 2, cells + 2, cells + 1, cells)))
