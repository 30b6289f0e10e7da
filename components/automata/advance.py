"""Internal steps of a packing all of whose pairs stay linked: half a drift, a kick, half a drift (leapfrog, second order)."""

from __future__ import annotations

import numpy as np

from ..support.jit import jit
from .motion import TALLY_ROWS, Grip, Load, add_loads, hold, keep_velocities, settle_loads
from .sweep import DRIFT_KICK_DRIFT, STILL, sweep

# What `advance` returns.
DONE, TOO_FAST = 0, 1
# What `advance` takes where no input acts: marked automata, what is kept of them, load, grip, and tallies.
_NOBODY, _NOTHING = np.zeros(0, np.int64), np.zeros((0, 6))
_NO_INPUTS = (
    _NOBODY, _NOTHING, Load(_NOBODY, _NOTHING), _NOTHING, Grip(_NOBODY, _NOBODY, _NOTHING), _NOTHING, np.zeros((2, TALLY_ROWS)),
)  # fmt: skip


@jit
def settle(body, reference, motion, marked, kept, force, torque, load, load_before, grip, grip_before, tallies, time):
    """Kick automata that inputs act on once more, with loads and grip; `sweep` has kicked them without.

    Args:
        body: a `Body`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`, updated in place.
        marked: automata that inputs act on, shape (m,).
        kept: see `sweep.sweep`, shape (m, 6).
        force: of the links on these, shape (n, 2), updated in place [N].
        torque: likewise, shape (n,) [N m].
        load: a `Load`.
        load_before: scratch, shape (loads, 2).
        grip: a `Grip`.
        grip_before: scratch, shape (grips, 3).
        tallies: of the loads and of the grip, see `motion`, shape (2, 4), updated in place.
        time: length of the step [s].

    Returns:
        The largest squared speed [m^2/s^2] before velocities are prescribed; NaN where one is not a number any more.
    """
    for row in range(marked.size):
        i = marked[row]
        motion.displacement[i, 0], motion.displacement[i, 1] = kept[row, 0], kept[row, 1]
        motion.velocity[i, 0], motion.velocity[i, 1] = kept[row, 2], kept[row, 3]
        motion.rotation[i], motion.spin[i] = kept[row, 4], kept[row, 5]
    add_loads(load, reference, motion, force, time, load_before, tallies[0])
    keep_velocities(grip, motion, grip_before)
    v, fastest = motion.velocity, 0.0
    for row in range(marked.size):
        i, k = marked[row], body.kind[marked[row]]
        v[i, 0] += time / body.mass[k] * force[i, 0]
        v[i, 1] += time / body.mass[k] * force[i, 1]
        motion.spin[i] += time / body.inertia[k] * torque[i]
        square = v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1]
        fastest = fastest if square <= fastest else square
    hold(body, grip, reference, motion, force, torque, time, grip_before, tallies[1])
    settle_loads(load, motion, time, load_before, tallies[0])
    for row in range(marked.size):
        i = marked[row]
        motion.displacement[i, 0] += 0.5 * time * v[i, 0]
        motion.displacement[i, 1] += 0.5 * time * v[i, 1]
        motion.rotation[i] += 0.5 * time * motion.spin[i]
    return fastest


@jit
def advance(
    body, part, reference, motion, scratch, marked, kept, load, load_before, grip, grip_before, tallies, time, ticks,
    speed_limit, moves,
):  # fmt: skip
    """Advance by so many internal steps, or compute forces; the one kernel of all this, as it is long to compile.

    Args:
        body: a `Body`.
        part: a `schedule.Part`. One that is not the whole packing makes one step and leaves `settle` to the caller.
            So does the whole where it does not drift, is kicked, and drifts again.
        reference: as for `settle`, as the next ones.
        motion: see there.
        scratch: a `Scratch`, overwritten.
        marked: see there.
        kept: see there.
        load: see there.
        load_before: see there.
        grip: see there.
        grip_before: see there.
        tallies: see there.
        time: see there.
        ticks: how many.
        speed_limit: no automaton may be faster [m/s].
        moves: see `sweep.STILL`, with which volumetric strains and the forces of the links are written to the scratch.

    Returns:
        DONE, or TOO_FAST in the middle of a step.
    """
    u, v = motion.displacement.reshape(motion.displacement.size), motion.velocity.reshape(motion.velocity.size)
    force, torque, limit = scratch.force, scratch.torque, speed_limit * speed_limit
    rows, whole = force.reshape(force.size), part.end - part.begin == body.kind.size
    for _ in range(ticks):
        fast = sweep(
            body, part, u, v, motion.rotation, motion.spin, marked, kept, scratch.dilation, rows, torque, time, limit, moves
        )
        fastest = 0.0
        if whole and moves == DRIFT_KICK_DRIFT:
            fastest = settle(
                body, reference, motion, marked, kept, force, torque, load, load_before, grip, grip_before, tallies, time
            )
        if moves != STILL and (fast or not fastest <= limit):
            return TOO_FAST
    return DONE


def update_forces(body, part, motion, scratch):
    """Write the volumetric strains of the positions as they are, and the forces and torques of the links.

    Args:
        body: a `Body`.
        part: the packing as one `schedule.Part`, its rings overwritten.
        motion: a `Motion`; its velocities are not looked at.
        scratch: a `Scratch`, overwritten.
    """
    advance(body, part, motion.displacement, motion, scratch, *_NO_INPUTS, 0.0, 1, 0.0, STILL)
