"""Drift, kick, and what they add up: momenta, kinetic energies, what boundaries and forces give."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit

# Bits of `Grip.held`.
HOLDS_X, HOLDS_Y, HOLDS_ROTATION = 1, 2, 4
# Places in a tally of six: work, impulse along x and y, impulse moment about the origin.
WORK, IMPULSE_X, IMPULSE_Y, ANGULAR_IMPULSE = 0, 1, 2, 3
TALLY_ROWS = 4


class Grip(NamedTuple):
    """Automata whose velocities are prescribed.

    Attributes:
        automata: shape (m,), int64.
        held: sum of HOLDS_X, HOLDS_Y and HOLDS_ROTATION, shape (m,), int64.
        velocity: that they get, shape (m, 2) [m/s]; rotations that are held have none.
    """

    automata: npt.NDArray[np.int64]
    held: npt.NDArray[np.int64]
    velocity: FloatArray


class Load(NamedTuple):
    """Forces on some automata.

    Attributes:
        automata: shape (m,), int64; each may come more than once.
        force: shape (m, 2) [N].
        lever: from the centre of the automaton to the point where the force acts, shape (m, 2) [m].
    """

    automata: npt.NDArray[np.int64]
    force: FloatArray
    lever: FloatArray


@internal_inlined
def load_torque(load, place):
    """Return the torque of a load about the centre of its automaton [N m]."""
    return load.lever[place, 0] * load.force[place, 1] - load.lever[place, 1] * load.force[place, 0]


@internal
def drift(motion, time, begin, end):
    """Move automata from `begin` up to `end` for a time with their velocities.

    Args:
        motion: a `Motion`, updated in place.
        time: [s].
        begin: first automaton.
        end: after the last one.
    """
    u, v = motion.displacement, motion.velocity
    for i in range(begin, end):
        u[i, 0] += time * v[i, 0]
        u[i, 1] += time * v[i, 1]
        motion.rotation[i] += time * motion.spin[i]


@internal
def kick(body, motion, force, torque, time, begin, end):
    """Accelerate automata from `begin` up to `end`.

    Args:
        body: a `Body`.
        motion: a `Motion`, updated in place.
        force: shape (n, 2) [N].
        torque: shape (n,) [N m].
        time: for which they act [s].
        begin: first automaton.
        end: after the last one.

    Returns:
        The largest squared speed [m^2/s^2]; NaN where one is not a number any more.
    """
    v, largest = motion.velocity, 0.0
    for i in range(begin, end):
        k = body.kind[i]
        by = time / body.mass[k]
        vx, vy = v[i, 0] + by * force[i, 0], v[i, 1] + by * force[i, 1]
        v[i, 0], v[i, 1] = vx, vy
        motion.spin[i] += time / body.inertia[k] * torque[i]
        square = vx * vx + vy * vy
        if not square <= largest:
            if square != square:
                return square
            largest = square
    return largest


@internal
def held_speed(velocity, fastest, limit):
    """Return the largest squared speed [m^2/s^2] once velocities are prescribed: what is held is not as fast as a kick made it.

    Args:
        velocity: shape (n, 2) [m/s].
        fastest: the largest squared speed before that.
        limit: of squared speeds; looked for only where `fastest` is larger.
    """
    if fastest <= limit or fastest != fastest:
        return fastest
    largest = 0.0
    for i in range(velocity.shape[0]):
        square = velocity[i, 0] * velocity[i, 0] + velocity[i, 1] * velocity[i, 1]
        largest = square if square > largest or square != square else largest
    return largest


@internal
def add_loads(load, reference, motion, force, torque, time, before, tally):
    """Add loads to the forces and torques on their automata, and their impulses in the next kick to a tally.

    Args:
        load: a `Load`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`, before the kick.
        force: shape (n, 2), updated in place [N].
        torque: shape (n,), updated in place [N m].
        time: of the kick [s].
        before: velocities and spin before the kick, shape (m, 3), written; `settle_loads` needs them.
        tally: see TALLY_ROWS, shape (4,), updated in place.
    """
    for place in range(load.automata.size):
        i = load.automata[place]
        fx, fy, turning = load.force[place, 0], load.force[place, 1], load_torque(load, place)
        before[place, 0], before[place, 1] = motion.velocity[i, 0], motion.velocity[i, 1]
        before[place, 2] = motion.spin[i]
        force[i, 0] += fx
        force[i, 1] += fy
        torque[i] += turning
        x, y = reference[i, 0] + motion.displacement[i, 0], reference[i, 1] + motion.displacement[i, 1]
        tally[IMPULSE_X] += time * fx
        tally[IMPULSE_Y] += time * fy
        tally[ANGULAR_IMPULSE] += time * (x * fy - y * fx + turning)


@internal
def settle_loads(load, motion, time, before, tally):
    """Add the work of loads in a kick to a tally: force times the mean of the velocities before and after; so for torques."""
    for place in range(load.automata.size):
        i = load.automata[place]
        mean_x = 0.5 * (before[place, 0] + motion.velocity[i, 0])
        mean_y = 0.5 * (before[place, 1] + motion.velocity[i, 1])
        mean_spin = 0.5 * (before[place, 2] + motion.spin[i])
        work = load.force[place, 0] * mean_x + load.force[place, 1] * mean_y + load_torque(load, place) * mean_spin
        tally[WORK] += time * work


@internal
def keep_velocities(grip, motion, before):
    """Write the velocities and spins of held automata before a kick, shape (m, 3)."""
    for place in range(grip.automata.size):
        i = grip.automata[place]
        before[place, 0], before[place, 1] = motion.velocity[i, 0], motion.velocity[i, 1]
        before[place, 2] = motion.spin[i]


@internal
def hold(body, grip, reference, motion, force, torque, time, before, tally):
    """Give held automata their velocities after a kick, and tally what the grip did for that.

    Args:
        body: a `Body`.
        grip: a `Grip`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`, updated in place.
        force: that the kick applied, shape (n, 2) [N].
        torque: that the kick applied, shape (n,) [N m].
        time: of the kick [s].
        before: see `keep_velocities`, shape (m, 3).
        tally: see TALLY_ROWS, shape (4,), updated in place.
    """
    v = motion.velocity
    for place in range(grip.automata.size):
        i, held = grip.automata[place], grip.held[place]
        mass, inertia = body.mass[body.kind[i]], body.inertia[body.kind[i]]
        x, y = reference[i, 0] + motion.displacement[i, 0], reference[i, 1] + motion.displacement[i, 1]
        if held & HOLDS_X:
            impulse = mass * (grip.velocity[place, 0] - before[place, 0]) - time * force[i, 0]
            v[i, 0] = grip.velocity[place, 0]
            tally[WORK] += impulse * 0.5 * (before[place, 0] + v[i, 0])
            tally[IMPULSE_X] += impulse
            tally[ANGULAR_IMPULSE] -= y * impulse
        if held & HOLDS_Y:
            impulse = mass * (grip.velocity[place, 1] - before[place, 1]) - time * force[i, 1]
            v[i, 1] = grip.velocity[place, 1]
            tally[WORK] += impulse * 0.5 * (before[place, 1] + v[i, 1])
            tally[IMPULSE_Y] += impulse
            tally[ANGULAR_IMPULSE] += x * impulse
        if held & HOLDS_ROTATION:
            impulse = -inertia * before[place, 2] - time * torque[i]
            motion.spin[i] = 0.0
            tally[WORK] += impulse * 0.5 * before[place, 2]
            tally[ANGULAR_IMPULSE] += impulse


@jit
def momenta(body, reference, motion, out):
    """Write momentum (x, y), angular momentum about the origin, kinetic energy of translation and of rotation, shape (5,)."""
    out[:] = 0.0
    for i in range(body.kind.size):
        mass, inertia = body.mass[body.kind[i]], body.inertia[body.kind[i]]
        vx, vy, w = motion.velocity[i, 0], motion.velocity[i, 1], motion.spin[i]
        x, y = reference[i, 0] + motion.displacement[i, 0], reference[i, 1] + motion.displacement[i, 1]
        out[0] += mass * vx
        out[1] += mass * vy
        out[2] += mass * (x * vy - y * vx) + inertia * w
        out[3] += 0.5 * mass * (vx * vx + vy * vy)
        out[4] += 0.5 * inertia * w * w
