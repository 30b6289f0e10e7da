"""Gases in tubes for several tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.components.detonation import DetonationTube
from granular_env.components.detonation.gases import Gas
from granular_env.components.detonation.theory import TaylorWave
from granular_env.components.support.float_arrays import FloatArray

# Pressure, density and temperature are 1 by default; the speed of sound is sqrt(1.4).
AIR = Gas(gamma=1.4, gas_constant=1.0)
# Largest wave speed in the tests.
FASTEST = 2.6


def air_tube(cells: int, **parameters: Any) -> DetonationTube:
    """Return a tube of unit length and area, full of air at rest."""
    plain = {
        "gas": AIR, "initial_pressure": 1.0, "initial_temperature": 1.0, "cross_section": 1.0, "length": 1.0,
        "ignition_zone": [0.0, 0.1], "step_size": 0.5 / cells / FASTEST,
    }  # fmt: skip
    return DetonationTube(cells=cells, **{**plain, **parameters})


def advance_tube(tube: DetonationTube, duration: float, **inputs: Any) -> None:
    """Step for about a given time, rounded to a whole number of ticks [s]."""
    tube.step(round(duration / tube.step_size) * tube.step_size, **inputs)


def sod_tube(cells: int) -> DetonationTube:
    """Return Sod's problem: pressure 1 on the left, 0.1 on the right, densities 1 and 0.125."""
    low = {"x": [0.5, 1.0], "pressure": 0.1, "temperature": 0.8}
    return air_tube(cells, left="absorbing", right="absorbing", regions=[low], step_size=0.2 / cells)


def detonating_tube(cells: int = 760, length: float = 1.52, **parameters: Any) -> DetonationTube:
    """Return C2H4 + 3 O2, ignited at the closed end by two hot cells so weakly that they leave no trace."""
    times = 12.0
    initial = parameters.get("initial_pressure", 1e5)
    hot = {"x": [0.0, 2.0 * length / cells], "pressure": times * initial, "temperature": times * 295.0}
    return DetonationTube(cells=cells, length=length, **{"regions": [hot], **parameters})


def front_ratio(tube: DetonationTube, begin: float, end: float) -> float:
    """Return the mean speed of the front between two positions [m], divided by the Chapman-Jouguet speed."""
    first, last = np.searchsorted(tube.centres, [begin, end])
    arrival = tube.get("arrival_time")
    speed = (tube.centres[last] - tube.centres[first]) / (arrival[last] - arrival[first])
    return float(speed / tube.front.speed)


def taylor_wave(tube: DetonationTube) -> TaylorWave:
    """Return the theoretical wave behind the front."""
    return TaylorWave(tube.front, tube.ahead, tube.gas.gamma)


def cell_means(density: FloatArray, velocity: FloatArray, pressure: FloatArray, cells: int) -> FloatArray:
    """Return density, velocity and pressure of cells with the mass, momentum and energy of the fine samples in them."""
    mean = lambda values: values.reshape(cells, -1).mean(axis=1)  # noqa: E731
    r, m = mean(density), mean(density * velocity)
    energy = mean(pressure / (AIR.gamma - 1.0) + 0.5 * density * velocity**2)
    return np.stack([r, m / r, (AIR.gamma - 1.0) * (energy - 0.5 * m * m / r)])
