"""Loads and grips of automata in a kick, drift, kick step: as those of `automata.motion`, which drifts first.

A load acts in both half kicks of a tick, and its work is force times the mean of the velocities before and after the tick: with
it the energy that leapfrog conserves closes to rounding.
"""

from __future__ import annotations

from typing import NamedTuple

from ..automata.motion import (
    ANGULAR_IMPULSE,
    HOLDS_ROTATION,
    HOLDS_X,
    HOLDS_Y,
    IMPULSE_X,
    IMPULSE_Y,
    WORK,
    Grip,
    Load,
    load_torque,
)
from ..support.float_arrays import FloatArray
from ..support.jit import internal


class Edges(NamedTuple):
    """Inputs and edges of the automata, as a coupled medium applies them.

    Attributes:
        load: forces on automata that do not belong to the interface; 0 along what the grip holds.
        grip: velocities that are prescribed.
        load_before: scratch: velocities and spin before the tick, shape (l, 3).
        grip_before: scratch: velocities, spin and displacements before the tick, shape (g, 5).
        grip_force: scratch: forces and torque before the tick, shape (g, 3).
    """

    load: Load
    grip: Grip
    load_before: FloatArray
    grip_before: FloatArray
    grip_force: FloatArray


@internal
def keep_before(edges, motion, force, torque):
    """Write velocities and forces before the first half kick."""
    for place in range(edges.load.automata.size):
        i = edges.load.automata[place]
        edges.load_before[place, 0], edges.load_before[place, 1] = motion.velocity[i, 0], motion.velocity[i, 1]
        edges.load_before[place, 2] = motion.spin[i]
    for place in range(edges.grip.automata.size):
        i = edges.grip.automata[place]
        edges.grip_before[place, 0], edges.grip_before[place, 1] = motion.velocity[i, 0], motion.velocity[i, 1]
        edges.grip_before[place, 2] = motion.spin[i]
        edges.grip_before[place, 3], edges.grip_before[place, 4] = motion.displacement[i, 0], motion.displacement[i, 1]
        edges.grip_force[place, 0], edges.grip_force[place, 1] = force[i, 0], force[i, 1]
        edges.grip_force[place, 2] = torque[i]


@internal
def push_and_hold(edges, body, reference, motion, time, tally):
    """Let the loads act for a half kick of `time` [s], tally their moment, and give held automata their velocities."""
    u, v = motion.displacement, motion.velocity
    for place in range(edges.load.automata.size):
        i = edges.load.automata[place]
        fx, fy, by = edges.load.force[place, 0], edges.load.force[place, 1], time / body.mass[body.kind[i]]
        turning = load_torque(edges.load, place)
        v[i, 0] += by * fx
        v[i, 1] += by * fy
        motion.spin[i] += time / body.inertia[body.kind[i]] * turning
        tally[ANGULAR_IMPULSE] += time * ((reference[i, 0] + u[i, 0]) * fy - (reference[i, 1] + u[i, 1]) * fx + turning)
    for place in range(edges.grip.automata.size):
        i, held = edges.grip.automata[place], edges.grip.held[place]
        if held & HOLDS_X:
            v[i, 0] = edges.grip.velocity[place, 0]
        if held & HOLDS_Y:
            v[i, 1] = edges.grip.velocity[place, 1]
        if held & HOLDS_ROTATION:
            motion.spin[i] = 0.0


@internal
def settle_loads(edges, motion, time, tally):
    """Tally work and impulse of the loads over a whole tick of `time` [s]."""
    for place in range(edges.load.automata.size):
        i, before = edges.load.automata[place], edges.load_before
        fx, fy = edges.load.force[place, 0], edges.load.force[place, 1]
        mean_x, mean_y = 0.5 * (before[place, 0] + motion.velocity[i, 0]), 0.5 * (before[place, 1] + motion.velocity[i, 1])
        mean_spin = 0.5 * (before[place, 2] + motion.spin[i])
        tally[WORK] += time * (fx * mean_x + fy * mean_y + load_torque(edges.load, place) * mean_spin)
        tally[IMPULSE_X] += time * fx
        tally[IMPULSE_Y] += time * fy


@internal
def settle_grip(edges, body, reference, motion, force, torque, time, tally):
    """Tally what held automata were given over a whole tick of `time` [s], forces after it being `force` and `torque`."""
    u = motion.displacement
    for place in range(edges.grip.automata.size):
        i, held = edges.grip.automata[place], edges.grip.held[place]
        mass, inertia = body.mass[body.kind[i]], body.inertia[body.kind[i]]
        for k in range(2):
            if held & (HOLDS_X, HOLDS_Y)[k]:
                before, given, old = edges.grip_before[place, k], edges.grip.velocity[place, k], edges.grip_force[place, k]
                new = force[i, k]
                first, second = mass * (given - before) - 0.5 * time * old, -0.5 * time * new
                lever = reference[i, 1 - k] + u[i, 1 - k]
                lever_before = reference[i, 1 - k] + edges.grip_before[place, 4 - k]
                sign = 1.0 if k == 1 else -1.0
                tally[WORK] += 0.5 * mass * (given * given - before * before) - 0.5 * time * given * (old + new)
                tally[IMPULSE_X + k] += first + second
                tally[ANGULAR_IMPULSE] += sign * (lever_before * first + lever * second)
        if held & HOLDS_ROTATION:
            spin, turned = edges.grip_before[place, 2], 0.5 * time * (edges.grip_force[place, 2] + torque[i])
            tally[WORK] -= 0.5 * inertia * spin * spin
            tally[ANGULAR_IMPULSE] -= inertia * spin + turned
