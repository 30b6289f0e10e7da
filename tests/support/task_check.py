"""Check of a task: replay a random episode from saved states."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

from granular_env.components.errors import one_line
from granular_env.envs import ComponentEnv


def check_task(env: gymnasium.Env[Any, Any], *, steps: int = 200, seed: int = 0) -> int:
    """Play an episode of random actions twice, the second time with each step repeated from a saved state, and compare.

    A task fails if it has state outside its counters, keeps state from an earlier episode, or draws random numbers in
    `begin_episode` or `evaluate_step`. Return the number of actions played.
    """
    one = env.unwrapped
    assert isinstance(one, ComponentEnv)
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, *(one.action_space.shape or ())))
    twin = copy.deepcopy(one)
    first = dict(_transcript(twin, actions, seed, 1))
    for number, found in _transcript(twin, actions, seed, 2):
        for name, value in first[number].items():
            same = np.asarray(value).tobytes() == np.asarray(found.get(name)).tobytes()
            assert same, (
                f"task {one.task.name!r}: {name}: {one_line(found.get(name))} after action {number}, not {one_line(value)}"
            )
    return max(first)


def _transcript(env: ComponentEnv, actions: np.ndarray, seed: int, attempts: int) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield the agent's results of the reset (0), and of `attempts` repetitions of each action from the same saved state."""
    observation, info = env.reset(seed=seed)
    yield 0, {**info, "observation": observation}
    for number, action in enumerate(actions, 1):
        before, over = env.save(), False
        for attempt in range(attempts):
            if attempt:
                env.restore(before)
            observation, reward, terminated, truncated, info = env.step(action)
            over = terminated or truncated
            yield number, {"reward": reward, "end": (terminated, truncated), **info, "observation": observation}
        if over:
            return
