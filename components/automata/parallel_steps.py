"""Steps of a large packing on two threads: each sweeps through a part, one applies the inputs; the bits are those of one."""

from __future__ import annotations

from typing import Any

from ..support.jit import jit
from ..support.second_thread import available, call_both
from .linked_steps import DONE, TOO_FAST, settle
from .linked_sweep import DRIFT_KICK_DRIFT, copy_ghosts, sweep
from .sweep_order import Part

__all__ = ["LEAST_AUTOMATA", "advance", "available"]

# Below this a tick is too short for two threads to meet in: measured, see docs/benchmarks.md.
LEAST_AUTOMATA = 50_000


def advance(body: Any, parts: list[Part], reference: Any, motion: Any, scratch: Any, *inputs: Any) -> int:
    """Advance a packing of two parts as `linked_steps.advance` does, whose arguments it takes."""
    *acting, time, ticks, speed_limit = inputs
    marked, kept, load, load_before, grip, grip_before, tallies = acting
    moved, limit = (motion.displacement.reshape(-1), motion.velocity.reshape(-1), motion.rotation, motion.spin), speed_limit**2
    first, second = ((body, part, motion, scratch, marked, kept, time, limit, DRIFT_KICK_DRIFT) for part in parts)
    for _ in range(ticks):
        for part in parts:
            copy_ghosts(part, *moved)
        fast = call_both(sweep, first, second)
        fastest = settle_inputs(
            body, reference, motion, marked, kept, scratch.force, scratch.torque, load, load_before, grip, grip_before, tallies,
            time,
        )  # fmt: skip
        if any(fast) or not fastest <= limit:
            return TOO_FAST
    return DONE


@jit
def settle_inputs(body, reference, motion, marked, kept, force, torque, load, load_before, grip, grip_before, tallies, time):
    """Call `linked_steps.settle`: its entry from Python, compiled where threads are used."""
    return settle(body, reference, motion, marked, kept, force, torque, load, load_before, grip, grip_before, tallies, time)
