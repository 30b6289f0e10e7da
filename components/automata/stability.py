"""The largest frequency of a packing, by power iteration: what limits the step."""

from __future__ import annotations

import math

import numpy as np

from ..support.counter_random import uniform
from ..support.jit import jit
from ..support.recent import Recent
from .linked import dilations, forces
from .pair import orient
from .state import Body, make_scratch

# Amplitude of displacements over the diameter and of rotations: what is not linear is as small as this.
_AMPLITUDE = 1e-9
# Rounds between two looks at the progress, when to stop, and how many rounds and automata times rounds there are at most.
_ROUNDS, _CHANGE, _MOST_ROUNDS, _MOST_WORK = 20, 1e-5, 1000, 30_000_000
# The parts of the limit 2 / omega_max of leapfrog that a step may take, and that the default takes.
ALLOWED_PART, DEFAULT_PART = 0.9, 0.7

_found = Recent()


def largest_frequency(body: Body) -> float:
    """Return the largest frequency of small motions of a linked packing, from below [rad/s]."""
    return _found.get(body, lambda: _compute_frequency(body))


def _compute_frequency(body: Body) -> float:
    count = len(body.kind)
    scratch = make_scratch(count)
    vector = uniform(1, 1, 3 * count).reshape(count, 3) - 0.5
    square, rounds = 0.0, 0
    while rounds < _MOST_ROUNDS:
        before, square = square, _iterate(body, scratch, vector, _ROUNDS)
        rounds += _ROUNDS
        if square - before <= _CHANGE * square or rounds * count > _MOST_WORK:
            break
    return math.sqrt(square)


@jit
def _iterate(body, scratch, vector, rounds):
    """Apply M^-1 K so many times to a vector (displacements in diameters, rotations), shape (n, 3), and scale it each time.

    Returns:
        The Rayleigh quotient of the last round, the square of a frequency.
    """
    count, length, quotient = body.kind.size, body.diameter, 0.0
    u, w = np.zeros((count, 2)), np.zeros(count)
    for _ in range(rounds):
        norm = 0.0
        for i in range(count):
            k = body.kind[i]
            norm += (
                body.mass[k] * length * length * (vector[i, 0] ** 2 + vector[i, 1] ** 2) + body.inertia[k] * vector[i, 2] ** 2
            )
        size = _AMPLITUDE / np.sqrt(norm / (body.mass[body.kind[0]] * length * length))
        for i in range(count):
            u[i, 0], u[i, 1], w[i] = size * length * vector[i, 0], size * length * vector[i, 1], size * vector[i, 2]
        orient(w, scratch.half, 0, count)
        dilations(body, u, scratch.half, scratch.dilation, 0, count)
        forces(body, u, scratch.half, scratch.dilation, scratch.force, scratch.torque, 0, count)
        work, norm = 0.0, 0.0
        for i in range(count):
            k, fx, fy, torque = body.kind[i], scratch.force[i, 0], scratch.force[i, 1], scratch.torque[i]
            work -= u[i, 0] * fx + u[i, 1] * fy + w[i] * torque
            norm += body.mass[k] * (u[i, 0] * u[i, 0] + u[i, 1] * u[i, 1]) + body.inertia[k] * w[i] * w[i]
        quotient = work / norm
        scale = 1.0 / (size * quotient)
        for i in range(count):
            k = body.kind[i]
            vector[i, 0] = -scale * scratch.force[i, 0] / (body.mass[k] * length)
            vector[i, 1] = -scale * scratch.force[i, 1] / (body.mass[k] * length)
            vector[i, 2] = -scale * scratch.torque[i] / body.inertia[k]
    return quotient


def step_limit(frequency: float) -> float:
    """Return the largest step with which leapfrog is stable [s]."""
    return 2.0 / frequency
