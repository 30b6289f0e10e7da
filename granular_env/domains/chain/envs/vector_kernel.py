"""One control step of many chains in one call: act, advance, judge, observe, chain after chain."""

from __future__ import annotations

import numpy as np

from granular_env.components.chain.integrators import SIGNATURE as ADVANCE
from granular_env.components.support.addresses import caller
from granular_env.components.support.jit import jit
from granular_env.envs.time_observation import show_clock

from .actuator import actuate
from .episode_layout import COUNTERS, ELAPSED, LEFT, RIGHT, RUNNING, SEED, START
from .sensors import OBSERVE, show_goal
from .task import JUDGE

_advance = caller(ADVANCE)
_judge = caller(JUDGE)
_observe = caller(OBSERVE)


@jit
def step_environments(
    tables, memories, actions, going,
    advances, judges, constants, places, counters, lengths, steps, durations,
    sides, scales, rates, delay, hold,
    observes, blocks, factors, limits, noises, goals, clock,
    drive, kept, kept_memory, first,
    observations, rewards, terminated, truncated, refused,
):  # fmt: skip
    """Each environment that is `going`: one action as `ChainEnv.step` takes it, with the same bits.

    Environment k is `tables[k]`, `memories[k]` and row k of all that is as long. One whose chain refuses is put back to
    where it was, and marked in `refused`. Returns how many are refused, or have ended.

    `advances`, `judges` and `observes` are addresses; environment k has the `constants` from `places[k]` to `places[k + 1]`,
    and as many as its task needs; `counters`, `delay`, `hold` and `clock` are counts; `lengths` internal steps of a control
    step; `drive` no pieces of a drive; `kept` and `kept_memory` room for a chain's state, whose rows begin with `first`, and
    for a memory.
    """
    special, none = 0, np.int64(0)
    for k in range(len(going)):
        refused[k] = False
        if not going[k]:
            continue
        a, memory = tables[k], memories[k]
        tally, commands = memory[COUNTERS : COUNTERS + counters], memory[COUNTERS + counters :]
        inputs = memory[LEFT : RIGHT + 1]
        _keep(a, first, memory, kept, kept_memory)
        total, over, late = 0.0, False, False
        for _ in range(hold):
            actuate(actions[k], sides, scales[k], rates[k], delay, commands, inputs)
            tick = np.int64(memory[START] + memory[ELAPSED] * lengths[k])
            done = _advance(advances[k], (a, drive, none, inputs[0], inputs[1], tick, lengths[k]))
            if done != lengths[k]:
                _put_back(a, first, memory, kept, kept_memory)
                refused[k] = True
                break
            memory[ELAPSED] += 1.0
            elapsed = np.int64(memory[ELAPSED])
            reward, over = _judge(
                judges[k], (a, inputs, tally, constants[places[k] : places[k + 1]], durations[k], elapsed, steps[k])
            )
            total += reward
            late = not over and elapsed >= steps[k] and steps[k] > 0
            if over or late or reward != reward:
                break
        if refused[k]:
            special += 1
            continue
        terminated[k] = over or (late and clock > 0)
        rewards[k], truncated[k] = total, late and clock == 0
        if over or late:
            memory[RUNNING] = 0.0
            special += 1
        _show(a, memory, steps[k], observes[k], blocks, factors[k], limits[k], noises[k], goals[k], clock, observations[k])
    return special


@jit
def observe_environments(tables, memories, steps, observes, blocks, factors, limits, noises, goals, clock, observations):
    """Write the present observation of every environment."""
    for k in range(len(limits)):
        _show(
            tables[k], memories[k], steps[k], observes[k], blocks, factors[k], limits[k], noises[k], goals[k], clock,
            observations[k],
        )  # fmt: skip


@jit
def _show(a, memory, steps, observe, blocks, factors, limit, noise, goal, clock, out):
    """One environment's readings, goal and clock."""
    elapsed, end = np.int64(memory[ELAPSED]), len(out) - clock
    _observe(observe, (a, blocks, factors, limit, noise, np.int64(memory[SEED]), elapsed, out))
    show_goal(memory[COUNTERS:], goal, limit, out[:end])
    if clock > 0:
        show_clock(elapsed, steps, out[end:])


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
