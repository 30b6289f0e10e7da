"""Loads (given forces) and grips (given velocities) in kicks, drifts; sums: momenta, energies, work and impulse of inputs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, spliced
from .lattice import FORCE_X, FORCE_Y, INERTIA, MASS, SPIN, TORQUE, VX, VY, X, Y

# Bits of `Grip.held`: the velocity components that are prescribed.
HOLDS_X, HOLDS_Y, HOLDS_ROTATION = 1, 2, 4
# Entries of a tally: work, impulse along x and y, moment of the impulse about the origin.
WORK, IMPULSE_X, IMPULSE_Y, ANGULAR_IMPULSE = 0, 1, 2, 3
TALLY_ROWS = 4


class Load(NamedTuple):
    """Forces on some automata.

    Attributes:
        automata: their numbers, shape (k,), int64; an automaton may occur several times.
        place: their indices in the fields, shape (k,).
        force: force on each, shape (k, 2) [N].
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
        automata: their numbers, shape (k,), int64.
        place: their indices in the fields, shape (k,).
        held: sum of HOLDS_X, HOLDS_Y and HOLDS_ROTATION, shape (k,), int64.
        velocity: prescribed velocity of each, shape (k, 2) [m/s]; held rotations have the rate 0.
        before: scratch: velocities and spin before a kick, shape (k, 3).
    """

    automata: npt.NDArray[np.int64]
    place: npt.NDArray[np.int64]
    held: npt.NDArray[np.int64]
    velocity: FloatArray
    before: FloatArray


class Inputs(NamedTuple):
    """A load, a grip, and the tallies of their work and impulses, shape (2, TALLY_ROWS)."""

    load: Load
    grip: Grip
    tallies: FloatArray


@internal_inlined
def load_torque(load, row):
    """Return the torque of row `row` of a load about the centre of its automaton [N m]."""
    return load.lever[row, 0] * load.force[row, 1] - load.lever[row, 1] * load.force[row, 0]


@internal
def drift(motion, time):
    """Move automata for a time [s] at their velocities."""
    for row in range(VX):
        value, rate = motion[row], motion[VX + row]
        for p in range(value.size):
            value[p] += time * rate[p]


@internal
def kick(body, motion, forces, time):
    """Accelerate automata for a time [s]; `forces` begins with the force rows of `lattice.Scratch.cells`."""
    for row in range(VX):
        velocity, force, mass = motion[VX + row], forces[row], body.cells[INERTIA if row == TORQUE else MASS]
        for p in range(velocity.size):
            velocity[p] += time / mass[p] * force[p]


@internal
def count_fast_automata(motion, limit):
    """Return the number of automata whose squared speed exceeds `limit` [m^2/s^2] or is NaN."""
    fast = 0
    for p in range(motion.shape[1]):
        fast += 0 if motion[VX, p] * motion[VX, p] + motion[VY, p] * motion[VY, p] <= limit else 1
    return fast


@internal
def largest_speed(motion):
    """Return the largest speed [m/s], ignoring NaN."""
    largest = 0.0
    for p in range(motion.shape[1]):
        square = motion[VX, p] * motion[VX, p] + motion[VY, p] * motion[VY, p]
        largest = square if square > largest else largest
    return np.sqrt(largest)


@internal_inlined
def save_velocities(place, motion, before):
    """Write the velocities and spins of automata before a kick to `before`, shape (k, 3)."""
    for row in range(place.size):
        p = place[row]
        before[row, 0], before[row, 1], before[row, 2] = motion[VX, p], motion[VY, p], motion[SPIN, p]


@internal
def kick_with_inputs(body, motion, forces, inputs, time):
    """Kick automata with forces and loads, then set the velocities of gripped automata.

    `forces`, rows of `lattice.Scratch.cells`, are updated on loaded automata, as are the tallies; `time` is that of the kick
    [s].
    """
    load, grip, tally = inputs.load, inputs.grip, inputs.tallies[0]
    save_velocities(load.place, motion, load.before)
    save_velocities(grip.place, motion, grip.before)
    for row in range(load.place.size):
        p = load.place[row]
        fx, fy, turning = load.force[row, 0], load.force[row, 1], load_torque(load, row)
        forces[FORCE_X, p] += fx
        forces[FORCE_Y, p] += fy
        forces[TORQUE, p] += turning
        tally[IMPULSE_X] += time * fx
        tally[IMPULSE_Y] += time * fy
        x, y = body.cells[X, p] + motion[X, p], body.cells[Y, p] + motion[Y, p]
        tally[ANGULAR_IMPULSE] += time * (x * fy - y * fx + turning)
    kick(body, motion, forces, time)
    hold_grip(body, motion, forces, inputs, time)
    for row in range(load.place.size):
        # The work of a force is force times the mean of the velocities before and after the kick, and likewise for torques.
        p = load.place[row]
        mean_x, mean_y = 0.5 * (load.before[row, 0] + motion[VX, p]), 0.5 * (load.before[row, 1] + motion[VY, p])
        mean_spin = 0.5 * (load.before[row, 2] + motion[SPIN, p])
        work = load.force[row, 0] * mean_x + load.force[row, 1] * mean_y + load_torque(load, row) * mean_spin
        tally[WORK] += time * work


@spliced
def hold_grip(body, motion, forces, inputs, time):
    """Set the velocities of gripped automata after a kick, and tally work and impulse of the grip."""
    grip, tally = inputs.grip, inputs.tallies[1]
    for row in range(grip.place.size):
        p, held = grip.place[row], grip.held[row]
        before_x, before_y, before_spin = grip.before[row, 0], grip.before[row, 1], grip.before[row, 2]
        if held & HOLDS_X:
            impulse = body.cells[MASS, p] * (grip.velocity[row, 0] - before_x) - time * forces[FORCE_X, p]
            motion[VX, p] = grip.velocity[row, 0]
            tally[WORK] += impulse * 0.5 * (before_x + motion[VX, p])
            tally[IMPULSE_X] += impulse
            tally[ANGULAR_IMPULSE] -= (body.cells[Y, p] + motion[Y, p]) * impulse
        if held & HOLDS_Y:
            impulse = body.cells[MASS, p] * (grip.velocity[row, 1] - before_y) - time * forces[FORCE_Y, p]
            motion[VY, p] = grip.velocity[row, 1]
            tally[WORK] += impulse * 0.5 * (before_y + motion[VY, p])
            tally[IMPULSE_Y] += impulse
            tally[ANGULAR_IMPULSE] += (body.cells[X, p] + motion[X, p]) * impulse
        if held & HOLDS_ROTATION:
            impulse = -body.cells[INERTIA, p] * before_spin - time * forces[TORQUE, p]
            motion[SPIN, p] = 0.0
            tally[WORK] += impulse * 0.5 * before_spin
            tally[ANGULAR_IMPULSE] += impulse
