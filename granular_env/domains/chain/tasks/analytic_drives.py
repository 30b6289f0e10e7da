"""Drives of a left end made by hand from theory: what the chain that is missing there would do."""

from __future__ import annotations

import math

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.support.elementary_functions import exponential, root, spline_through
from granular_env.components.support.float_arrays import FloatArray

from .target_waves import (
    AMPLITUDE,
    DENSITY,
    GRAIN_MASS,
    PLACE,
    POINTS,
    REACH,
    SHAPES,
    SPEED,
    TABLES,
)

_FINE, _FINER = 16, 32
_RISE = 0.29
# What a wall feels of a front's force, 2^(6/5).
_SHARE = 2.2973967099940698
# Pushes that are tried, over the mean one: the logarithms of 1e-3 and 1e6.
_LEAST, _MOST = -6.907755278982137, 13.815510557964274


def passing_waves(shapes: FloatArray, goal: FloatArray, horizon: float, duration: float, steps: int, action: str) -> FloatArray:
    """Return what a left end feels and does while solitary waves pass through it to their places, shape (steps,).

    A force: the mean over each control step of the force of the missing grain -1 on grain 0. Grains i >= 0 carry the momentum
    m A sum_i f(i - x(t)), f the shape of the velocity and x the crest's place, and its change is the impulse: exact for the
    infinite chain. A piston: the mean velocity of grain 0.

    Args:
        shapes: of the waves, see `target_waves`.
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


def wave_velocities(shapes: FloatArray, goal: FloatArray, left: float, grains: int) -> FloatArray:
    """Return the velocities of the grains in waves that are on their way, shape (grains,) [m/s].

    Args:
        shapes: of the waves, see `target_waves`.
        goal: rows (amplitude [m/s], place, speed [grains/s]).
        left: time until they are due [s].
        grains: how many.
    """
    total = np.zeros(grains)
    for row, wave in enumerate(goal):
        if wave[AMPLITUDE] > 0.0:
            place, values = _velocity_shape(shapes, row)
            crest = wave[PLACE] - wave[SPEED] * left
            total += wave[AMPLITUDE] * np.interp(np.arange(grains) - crest, place, values, left=0.0, right=0.0)
    return total


def ramped_push(chain: Chain, impulse: float, duration: float, steps: int, action: str) -> FloatArray:
    """Return a push that rises evenly to a level F and stays, which gives a wall its impulse in time, shape (steps,).

    A front of force F runs at D = (F k^2)^(1/6) / sqrt(m) grains/s (`theory.shock_speed`), its grains at F/(m D). A rigid wall
    doubles the particle velocity's share: in a simple wave v goes with overlap^(5/4) and F with overlap^(3/2), so the wall
    feels 2^(6/5) F. With a rise over r = 0.29 of the time T that there is,

        2^(6/5) F (T - n/D(F) - r/2) = impulse

    tells F, the smaller of two roots. Where time is too short for any F, that which delivers most.

    Args:
        chain: what is pushed; Hertz contacts.
        impulse: what the wall shall get [N s].
        duration: of a control step [s].
        steps: how many.
        action: the input, "left_force" or "left_velocity".
    """
    mass, stiffness, grains = (
        float(chain.geometry.mass.mean()),
        float(chain.geometry.stiffness[1:-1].mean()),
        len(chain.geometry.mass),
    )
    force = exponential(np.linspace(_LEAST, _MOST, 20_000)) * impulse / (duration * steps)
    speed = root(force * (stiffness * stiffness), 6) / math.sqrt(mass)
    rise = _RISE * duration * steps
    delivered = _SHARE * force * (duration * steps - grains / speed - 0.5 * rise)
    enough = np.flatnonzero(delivered >= impulse)
    chosen = enough[0] if len(enough) else int(np.argmax(delivered))
    level = force[chosen] if action.endswith("force") else force[chosen] / (mass * speed[chosen])
    return level * np.minimum((np.arange(steps) + 0.5) * duration / rise, 1.0)


def _velocity_shape(shapes: FloatArray, row: int) -> tuple[FloatArray, FloatArray]:
    """Fine table of a wave's velocity over the distance to its crest: cubics through the points of the shape."""
    count, density = int(shapes[POINTS]), shapes[DENSITY]
    table = TABLES + 2 * count * min(row, int(shapes[SHAPES]) - 1)
    place = (np.arange(count) - 1.0) / density - shapes[REACH]
    fine = np.linspace(place[0], place[-1], _FINER * (count - 1) + 1)
    return fine, spline_through(shapes[table : table + count], _FINER)
