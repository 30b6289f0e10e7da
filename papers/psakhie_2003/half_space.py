"""The paper's half-space under a short load: runs, velocities at a given time, and the exact solution.

The paper states no sizes, materials or loads. The shipped experiments ``psakhie-2003/lamb-...`` use our values (granite, a load
of 20 µs). Here the cells are finer and the load is smooth, because the corners of half-sine pulses contain waves as short as
the cells. x runs along the surface with the interface at 0, y upwards.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, RectBivariateSpline

from granular_env.components.drawables import Cells, Points
from granular_env.components.grid.theory import LineLoad
from granular_env.components.materials.elastic import Material
from granular_env.components.support.float_arrays import FloatArray
from granular_env.experiments import load_experiment
from pages import record

# Number of cells along the depth; cell size, equal to the diameter of the automata [m].
CELLS = 272
DEPTH = HALF_WIDTH = 0.4
SIZE = DEPTH / CELLS
MATERIAL = Material(density=2700.0, young=6e10, poisson=0.25)
P_SPEED, S_SPEED = MATERIAL.longitudinal_speed, MATERIAL.shear_speed
# The load: distance from the interface in figure 8 [m], duration [s], peak [N/m]; times of interest [s].
BESIDE, LOAD, PEAK = 0.1, 2e-5, 1e5
EARLY, LATE = 4e-5, 7e-5
# Depth below which the Rayleigh wave is negligible [m].
DEEP = 0.1
# Powers of t/T of the smooth pulse 64 (t/T)³ (1 - t/T)³.
PULSE = (0.0, 0.0, 0.0, 64.0, -192.0, 192.0, -64.0)
ROW = 0.5 * math.sqrt(3.0)
# Our reading of the paper's visual judgements, in percent of the largest value.
NOT_SEEN, SLIGHT = 2.0, 10.0
BY_EYE = f'The paper judges by eye; we read "not noticeable" as below {NOT_SEEN:g} % and "slight" as up to {SLIGHT:g} %.'


def internal_step(size: float, every: float) -> float:
    """Return the internal step for a cell size [m]: about 0.42 of the P wave's time per cell, dividing `every` [s]."""
    return every / math.ceil(every * P_SPEED / (0.42 * size))


def smooth_pulse(peak: float, duration: float, pattern: Sequence[Any]) -> dict[str, Any]:
    """Return the input table of a smooth pulse."""
    powers = [peak * factor / duration**power for power, factor in enumerate(PULSE)]
    return {"profile": "piecewise", "starts": [0.0, duration], "coefficients": [powers, [0.0]], "pattern": list(pattern)}


@functools.cache
def run_experiment(name: str) -> Any:
    """Return the log of the shipped experiment ``psakhie-2003/lamb-NAME`` with finer cells and a smooth load."""
    document = load_experiment(f"psakhie-2003/lamb-{name}").to_dict()
    component = document["component"]
    grid = component.get("grid", component)
    mesh = grid["mesh"]
    finer = mesh["cell_size"] / SIZE
    mesh |= {"columns": round(mesh["columns"] * finer), "rows": round(mesh["rows"] * finer), "cell_size": SIZE}
    grid["receivers"] = []
    if "automata" in component:
        component["automata"]["diameter"] = SIZE
        if component["automata"]["packing"] == "hexagonal":
            component["automata"]["shape"]["height"] = round(DEPTH / (ROW * SIZE)) * ROW * SIZE
    component["step_size"] = internal_step(SIZE, 1e-5)
    [(key, load)] = document["input"].items()
    document["input"] = {key: smooth_pulse(PEAK, LOAD, load["pattern"])}
    names = ["grid_velocity", "automata_velocity"] if "automata" in component else ["velocity"]
    document["record"] = {"every": 1e-5, "variables": names}
    document["duration"] = LATE
    return record(document)


class Part:
    """The velocities of the grid or the automata, with spline interpolation."""

    def __init__(self, points: FloatArray, velocity: FloatArray, shift: float = 0.0) -> None:
        """Sort points into columns and rows; both have shape (points, 2)."""
        x, column = np.unique(np.round(points[:, 0], 9), return_inverse=True)
        y, row = np.unique(np.round(points[:, 1], 9), return_inverse=True)
        if len(points) == len(x) * len(y):
            table = np.zeros((len(y), len(x), 2))
            table[row, column] = velocity
        else:  # Interpolate every other column of a hexagonal packing, which is shifted by half a diameter.
            y = np.sort(points[column == 0, 1])
            table = np.zeros((len(y), len(x), 2))
            for number in range(len(x)):
                own = np.flatnonzero(column == number)
                own = own[np.argsort(points[own, 1])]
                table[:, number] = CubicSpline(points[own, 1], velocity[own])(y)
        self.largest = float(np.linalg.norm(velocity, axis=1).max())
        self._splines = [RectBivariateSpline(y, x + shift, table[..., axis]) for axis in (0, 1)]

    def velocity_at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the velocity at points, shape (*x.shape, 2) [m/s]."""
        return np.stack([spline.ev(y, x) for spline in self._splines], axis=-1)


class Motion(NamedTuple):
    """Velocities in a half-space: in the left part (a grid) and in the right part."""

    left: Part
    right: Part

    def velocity_at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the velocity at points, shape (*x.shape, 2) [m/s]."""
        x, y = np.broadcast_arrays(x, y)
        return np.where((x < 0.0)[..., None], self.left.velocity_at(x, y), self.right.velocity_at(x, y))

    def spin(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the rate of rotation (dv_y/dx - dv_x/dy) / 2 at points, positive anticlockwise [1/s]."""
        half = 0.5 * SIZE
        across = self.velocity_at(x + half, y)[..., 1] - self.velocity_at(x - half, y)[..., 1]
        up = self.velocity_at(x, y + half)[..., 0] - self.velocity_at(x, y - half)[..., 0]
        return 0.5 * (across - up) / (2.0 * half)


@functools.cache
def motion(name: str, time: float = LATE) -> Motion:
    """Return the velocities in a run at a time [s]; a grid alone is shifted so that its load is at the position of figure 8."""
    log = run_experiment(name)
    [nodes] = [np.array(one.nodes) for one in log.drawables if isinstance(one, Cells)]
    if name == "grid":
        part = Part(nodes, log.get("velocity", time), -BESIDE)
        return Motion(part, part)
    [automata] = [np.array(one.reference) for one in log.drawables if isinstance(one, Points) and one.name == "automata"]
    parts = [(nodes, log.get("grid_velocity", time)), (automata, log.get("automata_velocity", time))]
    if "hexagonal" in name:  # The surface is x = 0; a clockwise rotation by 90 degrees moves it to the top.
        parts = [(_rotate_vectors(places), _rotate_vectors(velocity)) for places, velocity in parts]
    return Motion(*(Part(*part) for part in parts))


def _rotate_vectors(vectors: FloatArray) -> FloatArray:
    return np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)


def crest_position(places: FloatArray, values: FloatArray) -> float:
    """Return the position of the largest magnitude, with parabolic interpolation."""
    size = np.abs(values)
    i = int(np.clip(np.argmax(size), 1, len(size) - 2))
    before, at, after = size[i - 1 : i + 2]
    return float(places[i] + 0.5 * (places[1] - places[0]) * (before - after) / (before - 2.0 * at + after))


def lattice(left: float, right: float, spacing: float = 2e-3) -> tuple[FloatArray, FloatArray]:
    """Return a lattice of points over the depth of the half-space, with x in a given range and spacing: x and y [m]."""
    x, y = left + spacing * (np.arange(round((right - left) / spacing)) + 0.5), -2e-3 * np.arange(201.0)
    return tuple(np.meshgrid(x, y))  # type: ignore[return-value]


def exact_velocity(x: FloatArray, depth: FloatArray, time: float = LATE) -> FloatArray:
    """Return the exact velocities of Lamb's problem, x and upwards, shape (points, 2) [m/s]; points are right of the load.

    Using the time derivative of the load gives velocities instead of displacements.
    """
    slope = np.polynomial.Polynomial([PEAK * factor / LOAD**power for power, factor in enumerate(PULSE)]).deriv()
    solution = LineLoad(MATERIAL, slope, LOAD)
    down = [solution.displacement(float(p), float(d), np.array([time]))[0] for p, d in zip(x, depth, strict=True)]
    return np.array(down) * [1.0, -1.0]
