"""Drives of a left end made by hand from theory: what the chain that is missing there would do."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...components.chain.wanted_waves import AMPLITUDE, DENSITY, GRAIN_MASS, PLACE, POINTS, REACH, SHAPES, SPEED, TABLES

FloatArray = npt.NDArray[np.float64]

_FINE = 16


def passing_waves(
    shapes: FloatArray, goal: FloatArray, horizon: float, duration: float, steps: int, action: str
) -> FloatArray:
    """What a left end feels and does while solitary waves pass through it on their way to their places, shape (steps,).

    A force: the mean over each control step of the force of the missing grain -1 on grain 0. Grains i >= 0 carry the momentum
    m A sum_i f(i - x(t)), f the shape of the velocity and x the crest's place, and its change is the impulse: exact for the
    infinite chain. A piston: the mean velocity of grain 0.

    Args:
        shapes: of the waves, see `components.chain.wanted_waves`.
        goal: rows (amplitude [m/s], place, speed [grains/s]).
        horizon: when the waves are due [s].
        duration: of a control step [s].
        steps: how many.
        action: the input, "left_force" or "left_velocity".
    """
    total = np.zeros(steps)
    for row, wave in enumerate(goal):
        if wave[AMPLITUDE] <= 0.0:
            continue
        place, values = _velocity_shape(shapes, row)
        reach = float(shapes[REACH])
        fine = np.arange(steps * _FINE + 1) * (duration / _FINE)
        crest = wave[PLACE] - wave[SPEED] * (horizon - fine)
        if not action.endswith("force"):
            v = wave[AMPLITUDE] * np.interp(-crest, place, values, left=0.0, right=0.0)
            total += 0.5 * (v[:-1] + v[1:]).reshape(steps, _FINE).mean(axis=1)
            continue
        edges = crest[::_FINE]
        grains = np.arange(int(np.ceil(max(edges.max(), 0.0) + reach)) + 2)
        moving = np.interp(grains[None, :] - edges[:, None], place, values, left=0.0, right=0.0).sum(axis=1)
        total += shapes[GRAIN_MASS] * wave[AMPLITUDE] * np.diff(moving) / duration
    return total


def _velocity_shape(shapes: FloatArray, row: int) -> tuple[FloatArray, FloatArray]:
    """Fine table of a wave's velocity over the distance to its crest: cubics through the points of the shape."""
    from scipy.interpolate import CubicSpline

    count, density = int(shapes[POINTS]), shapes[DENSITY]
    table = TABLES + 2 * count * min(row, int(shapes[SHAPES]) - 1)
    place = (np.arange(count) - 1.0) / density - shapes[REACH]
    fine = np.linspace(place[0], place[-1], 32 * (count - 1) + 1)
    return fine, CubicSpline(place, shapes[table : table + count])(fine)
