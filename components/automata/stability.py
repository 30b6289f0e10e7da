"""The largest frequency of a packing, by power iteration: what limits the step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..support.counter_random import uniform
from ..support.jit import jit
from ..support.stable_step import ResultCache
from .lattice import Body, Motion, Scratch, make_motion, make_scratch, update_ghosts

# Amplitude of displacements over the diameter and of rotations: what is not linear is as small as this.
_AMPLITUDE = 1e-9
# Rounds between two looks at the progress, when to stop, and how many rounds and automata times rounds there are at most.
_ROUNDS, _CHANGE, _MOST_ROUNDS, _MOST_WORK = 20, 1e-5, 1000, 30_000_000
# The parts of the limit 2 / omega_max of leapfrog that a step may take, and that the default takes.
ALLOWED_PART, DEFAULT_PART = 0.9, 0.7

_found = {breakable: ResultCache() for breakable in (False, True)}


def largest_frequency(body: Body, update: Callable[[Motion, Scratch], object], breakable: bool) -> float:
    """Return the largest frequency of small motions of a linked packing, from below [rad/s].

    Args:
        body: the packing.
        update: writes the forces and torques of a motion to a scratch.
        breakable: whether these are computed by the kernels of links that may break: their last bits differ.
    """
    layout, *fields = body
    return _found[breakable].get((*layout, *fields), lambda: _compute_frequency(body, update))


def _compute_frequency(body: Body, update: Callable[[Motion, Scratch], object]) -> float:
    place = body.layout.place
    scratch, motion = make_scratch(body), make_motion(body.layout.size)
    vector = uniform(1, 1, 3 * len(place)).reshape(len(place), 3) - 0.5
    square, rounds = 0.0, 0
    while rounds < _MOST_ROUNDS:
        before = square
        for _ in range(_ROUNDS):
            size = _displace(body, vector, motion)
            update(motion, scratch)
            square = _iterate(body, motion, scratch, vector, size)
        rounds += _ROUNDS
        if square - before <= _CHANGE * square or rounds * len(place) > _MOST_WORK:
            break
    return math.sqrt(square)


@jit
def _displace(body, vector, motion):
    """Displace and turn automata by a vector (in diameters, in rad), shape (n, 3), times a small number; return that."""
    length, norm, place = body.diameter, 0.0, body.layout.place
    for i in range(place.size):
        p = place[i]
        norm += body.mass[p] * length * length * (vector[i, 0] ** 2 + vector[i, 1] ** 2) + body.inertia[p] * vector[i, 2] ** 2
    size = _AMPLITUDE / np.sqrt(norm / (body.mass[place[0]] * length * length))
    for i in range(place.size):
        p = place[i]
        motion.x[p], motion.y[p] = size * length * vector[i, 0], size * length * vector[i, 1]
        motion.angle[p] = size * vector[i, 2]
    update_ghosts(body.layout, motion.x)
    update_ghosts(body.layout, motion.y)
    update_ghosts(body.layout, motion.angle)
    return size


@jit
def _iterate(body, motion, scratch, vector, size):
    """Write M^-1 K of the vector that `_displace` took, scaled, from the forces; return the Rayleigh quotient."""
    forces, length, work, norm, place = scratch.forces, body.diameter, 0.0, 0.0, body.layout.place
    for i in range(place.size):
        p = place[i]
        x, y, w = motion.x[p], motion.y[p], motion.angle[p]
        work -= x * forces.x[p] + y * forces.y[p] + w * forces.torque[p]
        norm += body.mass[p] * (x * x + y * y) + body.inertia[p] * w * w
    scale = norm / (size * work)
    for i in range(place.size):
        p = place[i]
        vector[i, 0] = -scale * forces.x[p] / (body.mass[p] * length)
        vector[i, 1] = -scale * forces.y[p] / (body.mass[p] * length)
        vector[i, 2] = -scale * forces.torque[p] / body.inertia[p]
    return work / norm


def step_limit(frequency: float) -> float:
    """Return the largest step with which leapfrog is stable [s]."""
    return 2.0 / frequency


def damping_limit(slots: int, stiffness: float, mass: float, step: float) -> float:
    """Return the largest damping ratio of contacts with which a packing of automata that all touch is stable.

    With the velocities before a kick, leapfrog is stable for (w h)^2 + 2 h c w^2 / k < 4. The stiffest motion without friction
    has w^2 = s w_0^2, w_0^2 = 2 k / m that of two automata, s half the number of neighbours: zeta < 1 / (s w_0 h) - w_0 h / 4.

    Args:
        slots: neighbours of an automaton.
        stiffness: of a contact along the line of centres [N/m].
        mass: of an automaton [kg].
        step: internal step [s].
    """
    angle = step * math.sqrt(2.0 * stiffness / mass)
    return 1.0 / (0.5 * slots * angle) - 0.25 * angle
