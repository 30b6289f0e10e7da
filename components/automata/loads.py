"""Loads and grips in a kick, drifts, and their sums: momenta, kinetic energies, work and impulse of boundaries and forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit

# Bits of `Grip.held`.
HOLDS_X, HOLDS_Y, HOLDS_ROTATION = 1, 2, 4
# Places in a tally: work, impulse along x and y, impulse moment about the origin.
WORK, IMPULSE_X, IMPULSE_Y, ANGULAR_IMPULSE = 0, 1, 2, 3
TALLY_ROWS = 4


class Load(NamedTuple):
    """Forces on some automata.

    Attributes:
        automata: shape (k,), int64; each may come more than once.
        place: of these in the fields, shape (k,).
        force: shape (k, 2) [N].
        lever: from the centre of the automaton to the point where the force acts, shape (k, 2) [m].
        before: scratch: velocities and spin before a kick, shape (k, 3).
    """

    automata: npt.NDArray[np.int64]
    place: npt.NDArray[np.int64]
    force: FloatArray
    lever: FloatArray
    before: FloatArray


class Grip(NamedTuple):
    """Automata whose velocities are prescribed.

    Attributes:
        automata: shape (k,), int64.
        place: of these in the fields, shape (k,).
        held: sum of HOLDS_X, HOLDS_Y and HOLDS_ROTATION, shape (k,), int64.
        velocity: that they get, shape (k, 2) [m/s]; rotations that are held have none.
        before: scratch: velocities and spin before a kick, shape (k, 3).
    """

    automata: npt.NDArray[np.int64]
    place: npt.NDArray[np.int64]
    held: npt.NDArray[np.int64]
    velocity: FloatArray
    before: FloatArray


class Inputs(NamedTuple):
    """Loads and grips, and tallies of their work and impulses, shape (2, TALLY_ROWS)."""

    load: Load
    grip: Grip
    tallies: FloatArray


@internal_inlined
def load_torque(load, row):
    """Return the torque of a load about the centre of its automaton [N m]."""
    return load.lever[row, 0] * load.force[row, 1] - load.lever[row, 1] * load.force[row, 0]


@internal
def drift(motion, time):
    """Move automata for a time [s] with their velocities."""
    _advance(motion.x, motion.vx, time)
    _advance(motion.y, motion.vy, time)
    _advance(motion.angle, motion.spin, time)


@internal
def _advance(value, rate, time):
    for p in range(value.size):
        value[p] += time * rate[p]


@internal
def kick(body, motion, forces, time):
    """Accelerate automata for a time [s]."""
    _accelerate(motion.vx, forces.x, body.mass, time)
    _accelerate(motion.vy, forces.y, body.mass, time)
    _accelerate(motion.spin, forces.torque, body.inertia, time)


@internal
def _accelerate(velocity, force, mass, time):
    for p in range(velocity.size):
        velocity[p] += time / mass[p] * force[p]


@internal
def count_fast(motion, limit):
    """Return how many automata have a squared speed above a limit, or none that is a number."""
    fast = 0
    for p in range(motion.vx.size):
        fast += 0 if motion.vx[p] * motion.vx[p] + motion.vy[p] * motion.vy[p] <= limit else 1
    return fast


@internal
def largest_speed(motion):
    """Return the largest speed [m/s] of those that are numbers."""
    largest = 0.0
    for p in range(motion.vx.size):
        square = motion.vx[p] * motion.vx[p] + motion.vy[p] * motion.vy[p]
        largest = square if square > largest else largest
    return np.sqrt(largest)


@internal_inlined
def keep_velocities(place, motion, before):
    """Write the velocities and spins of automata before a kick, shape (k, 3)."""
    for row in range(place.size):
        p = place[row]
        before[row, 0], before[row, 1], before[row, 2] = motion.vx[p], motion.vy[p], motion.spin[p]


@internal
def kick_with_inputs(body, motion, forces, inputs, time):
    """Kick automata with the forces and with loads; then give held automata their velocities.

    Args:
        body: a `lattice.Body`.
        motion: a `lattice.Motion`, updated in place.
        forces: `lattice.Forces`; those on loaded automata are updated.
        inputs: `Inputs`; the tallies are updated.
        time: of the kick [s].
    """
    add_loads(body, motion, forces, inputs, time)
    keep_velocities(inputs.grip.place, motion, inputs.grip.before)
    kick(body, motion, forces, time)
    hold(body, motion, forces, inputs, time)
    settle_loads(inputs.load, motion, time, inputs.tallies[0])


@internal
def add_loads(body, motion, forces, inputs, time):
    """Add loads to the forces and torques, and their impulses in the next kick to the tally; arguments as above."""
    load, tally = inputs.load, inputs.tallies[0]
    keep_velocities(load.place, motion, load.before)
    for row in range(load.place.size):
        p = load.place[row]
        fx, fy, turning = load.force[row, 0], load.force[row, 1], load_torque(load, row)
        forces.x[p] += fx
        forces.y[p] += fy
        forces.torque[p] += turning
        tally[IMPULSE_X] += time * fx
        tally[IMPULSE_Y] += time * fy
        tally[ANGULAR_IMPULSE] += time * ((body.x[p] + motion.x[p]) * fy - (body.y[p] + motion.y[p]) * fx + turning)


@internal
def settle_loads(load, motion, time, tally):
    """Add the work of loads in a kick to a tally: force times the mean of the velocities before and after; so for torques."""
    for row in range(load.place.size):
        p = load.place[row]
        mean_x, mean_y = 0.5 * (load.before[row, 0] + motion.vx[p]), 0.5 * (load.before[row, 1] + motion.vy[p])
        mean_spin = 0.5 * (load.before[row, 2] + motion.spin[p])
        work = load.force[row, 0] * mean_x + load.force[row, 1] * mean_y + load_torque(load, row) * mean_spin
        tally[WORK] += time * work


@internal
def hold(body, motion, forces, inputs, time):
    """Give held automata their velocities after a kick, and tally the work and impulse of the grip; arguments as above."""
    grip, tally = inputs.grip, inputs.tallies[1]
    for row in range(grip.place.size):
        p, held = grip.place[row], grip.held[row]
        before_x, before_y, before_spin = grip.before[row, 0], grip.before[row, 1], grip.before[row, 2]
        if held & HOLDS_X:
            impulse = body.mass[p] * (grip.velocity[row, 0] - before_x) - time * forces.x[p]
            motion.vx[p] = grip.velocity[row, 0]
            tally[WORK] += impulse * 0.5 * (before_x + motion.vx[p])
            tally[IMPULSE_X] += impulse
            tally[ANGULAR_IMPULSE] -= (body.y[p] + motion.y[p]) * impulse
        if held & HOLDS_Y:
            impulse = body.mass[p] * (grip.velocity[row, 1] - before_y) - time * forces.y[p]
            motion.vy[p] = grip.velocity[row, 1]
            tally[WORK] += impulse * 0.5 * (before_y + motion.vy[p])
            tally[IMPULSE_Y] += impulse
            tally[ANGULAR_IMPULSE] += (body.x[p] + motion.x[p]) * impulse
        if held & HOLDS_ROTATION:
            impulse = -body.inertia[p] * before_spin - time * forces.torque[p]
            motion.spin[p] = 0.0
            tally[WORK] += impulse * 0.5 * before_spin
            tally[ANGULAR_IMPULSE] += impulse


@jit
def momenta(body, motion, out):
    """Write momentum (x, y), angular momentum about the origin, kinetic energy of translation and of rotation, shape (5,)."""
    out[:] = 0.0
    for i in range(body.layout.place.size):
        p = body.layout.place[i]
        mass, inertia, vx, vy, w = body.mass[p], body.inertia[p], motion.vx[p], motion.vy[p], motion.spin[p]
        out[0] += mass * vx
        out[1] += mass * vy
        out[2] += mass * ((body.x[p] + motion.x[p]) * vy - (body.y[p] + motion.y[p]) * vx) + inertia * w
        out[3] += 0.5 * mass * (vx * vx + vy * vy)
        out[4] += 0.5 * inertia * w * w
