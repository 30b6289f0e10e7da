"""Internal steps of a packing all of whose pairs stay linked: half a drift, a kick, half a drift (leapfrog, second order)."""

from __future__ import annotations

from ..support.jit import jit
from .linked import dilations, forces
from .motion import add_loads, drift, hold, keep_velocities, kick, settle_loads
from .pair import orient

# What `advance` returns.
DONE, TOO_FAST = 0, 1


@jit
def advance(body, reference, motion, scratch, load, load_before, grip, grip_before, tallies, time, ticks, speed_limit):
    """Advance by so many internal steps.

    Args:
        body: a `Body`.
        reference: centres before anything moved, shape (n, 2) [m].
        motion: a `Motion`, updated in place.
        scratch: a `Scratch`, overwritten.
        load: a `Load`.
        load_before: scratch, shape (loads, 2).
        grip: a `Grip`.
        grip_before: scratch, shape (grips, 3).
        tallies: of the loads and of the grip, see `motion`, shape (2, 4), updated in place.
        time: length of a step [s].
        ticks: how many.
        speed_limit: no automaton may be faster [m/s].

    Returns:
        DONE, or TOO_FAST in the middle of a step.
    """
    count = body.kind.size
    for _ in range(ticks):
        drift(motion, 0.5 * time, 0, count)
        orient(motion.rotation, scratch.half, 0, count)
        dilations(body, motion.displacement, scratch.half, scratch.dilation, 0, count)
        forces(body, motion.displacement, scratch.half, scratch.dilation, scratch.force, scratch.torque, 0, count)
        add_loads(load, reference, motion, scratch.force, time, load_before, tallies[0])
        keep_velocities(grip, motion, grip_before)
        fastest = kick(body, motion, scratch.force, scratch.torque, time, 0, count)
        hold(body, grip, reference, motion, scratch.force, scratch.torque, time, grip_before, tallies[1])
        settle_loads(load, motion, time, load_before, tallies[0])
        drift(motion, 0.5 * time, 0, count)
        if not fastest <= speed_limit * speed_limit:
            return TOO_FAST
    return DONE
