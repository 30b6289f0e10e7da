"""Tuples of plain arrays and numbers for kernels: the gas, the tube, the state, and scratch.

n cells of equal length. What is conserved is kept per volume of gas; what follows from it, and is needed at the next tick, is
kept beside it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray

IntArray = npt.NDArray[np.int64]


class Medium(NamedTuple):
    """Numbers that do not change.

    Attributes:
        gamma: adiabatic exponent.
        gas_constant: p / (rho T) [J/(kg K)].
        heat: that the whole reaction sets free [J/kg].
        cell_size: [m].
        step_size: [s].
        limiter: of slopes; see `limiters`.
        outside_temperature: of what flows in through open ends [K].
    """

    gamma: float
    gas_constant: float
    heat: float
    cell_size: float
    step_size: float
    limiter: float
    outside_temperature: float


class State(NamedTuple):
    """The changing arrays; all of one tick.

    Attributes:
        density: shape (n,) [kg/m^3].
        momentum: per volume, shape (n,) [kg/(m^2 s)].
        energy: thermal, kinetic and chemical, per volume, shape (n,) [J/m^3].
        fuel: mass that has not reacted, per volume, shape (n,) [kg/m^3].
        velocity: shape (n,) [m/s].
        pressure: shape (n,) [Pa].
        progress: part of the gas that has reacted, 0 to 1, shape (n,).
        area: cross-section, shape (n,) [m^2].
        arrival: time at which the progress passed 1/2, -1 where it has not, shape (n,) [s].
        flags: see `LEFT_OPEN` and the following, shape (FLAGS,).
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
        heated: first cell of the ignition zone, and the one behind its last, shape (2,).
        gauges: number of the gauge in each cell, -1 where there is none, shape (n,).
    """

    ends: IntArray
    burst: FloatArray
    reaction: Any
    heated: IntArray
    gauges: IntArray


class Scratch(NamedTuple):
    """Memory that holds nothing between ticks.

    Attributes:
        stage: density, velocity, pressure and the part that has not reacted, a ghost cell at each end, shape (4, n + 2).
        slopes: limited differences of these four over half a cell, shape (4, n + 2).
        fluxes: of mass, momentum, energy and fuel through each face, shape (4, n + 1).
        first: density, momentum, energy and fuel after the first stage, shape (4, n).
    """

    stage: FloatArray
    slopes: FloatArray
    fluxes: FloatArray
    first: FloatArray


class Tables(NamedTuple):
    """All that the kernels work on; `tally` has the entries named below, shape (TALLY,)."""

    medium: Medium
    tube: Tube
    state: State
    scratch: Scratch
    tally: FloatArray


class Events(NamedTuple):
    """The rows of events, with room for more, and how many are in use, shape (1,)."""

    rows: FloatArray
    used: IntArray


# Flags: whether the end is open now; whether anything has burnt; whether a front has reached the end.
LEFT_OPEN, RIGHT_OPEN, IGNITED, LEFT_REACHED, RIGHT_REACHED, FLAGS = 0, 1, 2, 3, 4, 5
# Entries of the tally since the reset, of the left end and then of the right one where there are two. PEAK is the largest
# pressure of unburnt gas, IDLE the number of ticks since gas burnt that has ignited, or since the reset.
MASS, IMPULSE, ENERGY, WALL_IMPULSE, WALL_WORK, IGNITION, OVERWRITTEN, PEAK, IDLE, TALLY = 0, 2, 4, 6, 7, 8, 9, 10, 11, 12
# Columns of the signals that a tick reads, each in its middle: W, Pa, Pa, the factor of the area, m/s, m/s.
POWER, LEFT_PRESSURE, RIGHT_PRESSURE, AREA, LEFT_VELOCITY, RIGHT_VELOCITY, SIGNALS = 0, 1, 2, 3, 4, 5, 6
# Statuses of a tick. The last two are those of a moving mesh, whose state is then that from before the tick: waves too fast for
# its cells at the velocities that the ends have in this tick, and ends that would leave less than half of the tube.
NOT_POSITIVE, TOO_FAST, BAD_AREA, TOO_FAST_AHEAD, ENDS_TOO_FAST = 1, 2, 3, 4, 5
# By so much a cross-section may grow or shrink in a tick: the pressure of the gas in it is then right within 4 %.
LARGEST_RATIO = 2.0


def make_scratch(cells: int) -> Scratch:
    """Return scratch for so many cells."""
    return Scratch(*(np.zeros((4, size)) for size in (cells + 2, cells + 2, cells + 1, cells)))
