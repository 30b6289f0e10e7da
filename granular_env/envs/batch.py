"""One control step of many chains in one call: act, advance, judge, observe, chain after chain."""

from __future__ import annotations

import numpy as np

from ..components.chain.integrators import SIGNATURE as ADVANCE
from ..components.jit import caller, jit
from .actuator import actuate
from .chain_task import JUDGE
from .memory import COUNTERS, ELAPSED, LEFT, RIGHT, RUNNING, SEED, START
from .observing import observe, show_goal

_advance = caller(ADVANCE)
_judge = caller(JUDGE)


@jit
def step_lanes(
    tables, memories, actions, going,
    advances, judge, constants, places, counters, lengths, steps, durations,
    sides, scales, rates, delay,
    blocks, factors, limits, noises, goals,
    drive, kept, kept_memory, first,
    observations, rewards, terminated, truncated, refused,
):  # fmt: skip
    """Each lane that is `going`: a control step as `ChainEnv.step` makes it, with the same bits.

    Lane k is `tables[k]`, `memories[k]` and row k of all that is as long. A lane whose chain refuses is put back to where it
    was, and marked in `refused`. Returns how many lanes are refused, or have ended.

    `advances` and `judge` are addresses; lane k has the `constants` from `places[k]` to `places[k + 1]`, and as many as its
    task needs; `counters` and `delay` are counts; `lengths` internal steps of a control step; `drive` no
    pieces of a drive; `kept` and `kept_memory` room for a chain's state, whose rows begin with `first`, and for a memory.
    """
    special, none = 0, np.int64(0)
    for k in range(len(going)):
        refused[k] = False
        if not going[k]:
            continue
        a, memory = tables[k], memories[k]
        tally, commands = memory[COUNTERS : COUNTERS + counters], memory[COUNTERS + counters :]
        inputs, out = memory[LEFT : RIGHT + 1], observations[k]
        _keep(a, first, memory, kept, kept_memory)
        actuate(actions[k], sides, scales[k], rates[k], delay, commands, inputs)
        tick = np.int64(memory[START] + memory[ELAPSED] * lengths[k])
        done = _advance(advances[k], (a, drive, none, inputs[0], inputs[1], tick, lengths[k]))
        if done != lengths[k]:
            _put_back(a, first, memory, kept, kept_memory)
            refused[k] = True
            special += 1
            continue
        memory[ELAPSED] += 1.0
        elapsed = np.int64(memory[ELAPSED])
        reward, over = _judge(judge, (a, inputs, tally, constants[places[k] : places[k + 1]], durations[k], elapsed, steps[k]))
        late = not over and elapsed >= steps[k] and steps[k] > 0
        rewards[k], terminated[k], truncated[k] = reward, over, late
        if over or late:
            memory[RUNNING] = 0.0
            special += 1
        observe(a, blocks, factors[k], limits[k], noises[k], np.int64(memory[SEED]), elapsed, out)
        show_goal(tally, goals[k], limits[k], out)
    return special


@jit
def observe_lanes(tables, memories, blocks, factors, limits, noises, goals, observations):
    """What every lane sees now."""
    for k in range(len(limits)):
        memory = memories[k]
        observe(
            tables[k], blocks, factors[k], limits[k], noises[k], np.int64(memory[SEED]), np.int64(memory[ELAPSED]),
            observations[k],
        )  # fmt: skip
        show_goal(memory[COUNTERS:], goals[k], limits[k], observations[k])


@jit
def _keep(a, first, memory, kept, kept_memory):
    for row in range(kept.shape[0]):
        for i in range(np.uint64(kept.shape[1])):
            kept[row, i] = a[first + row, i]
    for i in range(len(memory)):
        kept_memory[i] = memory[i]


@jit
def _put_back(a, first, memory, kept, kept_memory):
    for row in range(kept.shape[0]):
        for i in range(np.uint64(kept.shape[1])):
            a[first + row, i] = kept[row, i]
    for i in range(len(memory)):
        memory[i] = kept_memory[i]
