"""Two threads for a large packing: each sweeps through a part of it, then one applies the inputs; the bits are those of one."""

from __future__ import annotations

from typing import Any

from ..support.threads import available, call_both
from .advance import DONE, TOO_FAST, settle
from .advance import advance as advance_part
from .schedule import Part
from .sweep import copy_ghosts

__all__ = ["LEAST_AUTOMATA", "advance", "available"]

# Below this a tick is too short for two threads to meet in: measured, see docs/benchmarks.md.
LEAST_AUTOMATA = 50_000


def advance(body: Any, parts: list[Part], reference: Any, motion: Any, scratch: Any, *inputs: Any) -> int:
    """Advance a packing of two parts as `advance.advance` does, whose arguments it takes."""
    *acting, time, ticks, speed_limit, moves = inputs
    marked, kept, load, load_before, grip, grip_before, tallies = acting
    moved = motion.displacement.reshape(-1), motion.velocity.reshape(-1), motion.rotation, motion.spin
    first, second = ((body, part, reference, motion, scratch, *acting, time, 1, speed_limit, moves) for part in parts)
    for _ in range(ticks):
        for part in parts:
            copy_ghosts(part, *moved)
        statuses = call_both(advance_part, first, second)
        fastest = settle(
            body, reference, motion, marked, kept, scratch.force, scratch.torque, load, load_before, grip, grip_before, tallies,
            time,
        )  # fmt: skip
        if any(statuses) or not fastest <= speed_limit * speed_limit:
            return TOO_FAST
    return DONE
