"""Internal steps of a packing all of whose pairs stay linked: half a drift, a kick, half a drift (leapfrog, second order)."""

from __future__ import annotations

from ..support.jit import internal, jit
from .linked_sweep import DRIFT_KICK_DRIFT, sweep
from .motion import add_loads, hold, keep_velocities, settle_loads

# What `advance` returns.
DONE, TOO_FAST = 0, 1


@internal
def settle(body, reference, motion, marked, kept, force, torque, load, load_before, grip, grip_before, tallies, time):
    """Kick automata that inputs act on once more, with loads and grip; `sweep` has kicked them without.

    Args:
        body: a `Body`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`, updated in place.
        marked: automata that inputs act on, shape (m,).
        kept: see `linked_sweep.sweep`, shape (m, 6).
        force: of the links on these, shape (n, 2), updated in place [N].
        torque: likewise, shape (n,) [N m].
        load: a `Load`.
        load_before: scratch, shape (loads, 3).
        grip: a `Grip`.
        grip_before: scratch, shape (grips, 3).
        tallies: of the loads and of the grip, see `motion`, shape (2, 4), updated in place.
        time: length of the step [s].

    Returns:
        The largest squared speed of these [m^2/s^2]; NaN where one is not a number any more.
    """
    for row in range(marked.size):
        i = marked[row]
        motion.displacement[i, 0], motion.displacement[i, 1] = kept[row, 0], kept[row, 1]
        motion.velocity[i, 0], motion.velocity[i, 1] = kept[row, 2], kept[row, 3]
        motion.rotation[i], motion.spin[i] = kept[row, 4], kept[row, 5]
    add_loads(load, reference, motion, force, torque, time, load_before, tallies[0])
    keep_velocities(grip, motion, grip_before)
    v, fastest = motion.velocity, 0.0
    for row in range(marked.size):
        i, k = marked[row], body.kind[marked[row]]
        v[i, 0] += time / body.mass[k] * force[i, 0]
        v[i, 1] += time / body.mass[k] * force[i, 1]
        motion.spin[i] += time / body.inertia[k] * torque[i]
    hold(body, grip, reference, motion, force, torque, time, grip_before, tallies[1])
    settle_loads(load, motion, time, load_before, tallies[0])
    for row in range(marked.size):
        i = marked[row]
        square = v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1]
        fastest = square if square > fastest or square != square else fastest
        motion.displacement[i, 0] += 0.5 * time * v[i, 0]
        motion.displacement[i, 1] += 0.5 * time * v[i, 1]
        motion.rotation[i] += 0.5 * time * motion.spin[i]
    return fastest


@jit
def advance(
    body,
    part,
    reference,
    motion,
    scratch,
    marked,
    kept,
    load,
    load_before,
    grip,
    grip_before,
    tallies,
    time,
    ticks,
    speed_limit,
):
    """Advance by so many internal steps.

    Args:
        body: a `Body`.
        part: the packing as one `sweep_order.Part`, its rings overwritten.
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

    Returns:
        DONE, or TOO_FAST in the middle of a step.
    """
    limit = speed_limit * speed_limit
    for _ in range(ticks):
        fast = sweep(body, part, motion, scratch, marked, kept, time, limit, DRIFT_KICK_DRIFT)
        fastest = settle(
            body, reference, motion, marked, kept, scratch.force, scratch.torque, load, load_before, grip, grip_before, tallies,
            time,
        )  # fmt: skip
        if fast or not fastest <= limit:
            return TOO_FAST
    return DONE
