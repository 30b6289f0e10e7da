"""The highest frequency of small motions of a packing, by power iteration; it limits the step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..support.counter_random import uniform
from ..support.float_arrays import ordered_sum
from ..support.stable_step import ResultCache
from .lattice import INERTIA, MASS, TORQUE, VX, Body, Motion, Scratch, copy_to_ghosts, make_scratch

# Amplitude of displacements over the diameter, and of rotations, in the iteration: the relative size of nonlinear terms.
_AMPLITUDE = 1e-9
# Iterations between two tests for convergence, its tolerance, the most iterations, and the most iterations times automata.
_ROUNDS, _CHANGE, _MOST_ROUNDS, _MOST_WORK = 20, 1e-5, 1000, 30_000_000
# The largest step that is allowed, and the default step, as fractions of the leapfrog limit 2 / omega_max.
ALLOWED_PART, DEFAULT_PART = 0.9, 0.7

_found = {breakable: ResultCache() for breakable in (False, True)}


def highest_frequency(body: Body, update_forces: Callable[[Motion, Scratch], object], has_histories: bool) -> float:
    """Return a lower estimate of the highest frequency of small motions of a linked packing [rad/s].

    Args:
        body: the `lattice.Body` of the packing.
        update_forces: function that writes the forces and torques at a `Motion` to a `Scratch`.
        has_histories: whether `update_forces` uses the kernels of breakable links; results then differ in their last bits.
    """
    return _found[has_histories].get((*body.layout, *body[1:]), lambda: _compute_frequency(body, update_forces, has_histories))


def _compute_frequency(body: Body, update_forces: Callable[[Motion, Scratch], object], has_histories: bool) -> float:
    place, length = body.layout.place, body.diameter
    mass, inertia = body.cells[MASS : INERTIA + 1, place]
    units, weights = np.array([length, length, 1.0]), np.stack([mass, mass, inertia])
    scratch, motion = make_scratch(body, histories=has_histories), np.zeros((6, body.layout.size))
    vector = (uniform(1, 1, 3 * len(place)).reshape(len(place), 3) - 0.5).T
    square, rounds = 0.0, 0
    while rounds < _MOST_ROUNDS:
        before = square
        for _ in range(_ROUNDS):
            # Displacements in diameters and angles in rad, scaled to the small amplitude above.
            norm = ordered_sum(mass * length * length * (vector[0] ** 2 + vector[1] ** 2) + inertia * vector[2] ** 2)
            size = _AMPLITUDE / np.sqrt(norm / (mass[0] * length * length))
            motion[:VX, place] = size * units[:, np.newaxis] * vector
            copy_to_ghosts(body.layout, motion)
            update_forces(motion, scratch)
            (x, y, w), force = motion[:VX, place], scratch.cells[: TORQUE + 1, place]
            work = -ordered_sum(x * force[0] + y * force[1] + w * force[2])
            norm = ordered_sum(mass * (x * x + y * y) + inertia * w * w)
            vector = -(norm / (size * work)) * force / (weights * units[:, np.newaxis])
            square = work / norm
        rounds += _ROUNDS
        if square - before <= _CHANGE * square or rounds * len(place) > _MOST_WORK:
            break
    return math.sqrt(square)


def step_limit(frequency: float) -> float:
    """Return the largest step with which leapfrog is stable [s]."""
    return 2.0 / frequency


def damping_limit(slots: int, stiffness: float, mass: float, step: float) -> float:
    """Return the largest damping ratio zeta of contacts for which the scheme is stable in a packing of touching automata.

    With the velocities before a kick, leapfrog is stable for (w h)^2 + 2 h c w^2 / k < 4. The stiffest frictionless motion has
    w^2 = s w_0^2 with w_0^2 = 2 k / m for two automata and s half the number of neighbours: zeta < 1 / (s w_0 h) - w_0 h / 4.

    Args:
        slots: neighbours of an automaton.
        stiffness: of a contact along the line of centres [N/m].
        mass: of an automaton [kg].
        step: internal step [s].
    """
    angle = step * math.sqrt(2.0 * stiffness / mass)
    return 1.0 / (0.5 * slots * angle) - 0.25 * angle
