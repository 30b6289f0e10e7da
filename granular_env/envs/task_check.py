"""The check of a task of one's own: a random episode, played again from saved states."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

from ..components.errors import ParameterError, one_line
from .environment import ComponentEnv


def check_task(env: gymnasium.Env[Any, Any], *, steps: int = 200, seed: int = 0) -> int:
    """Play an episode of random actions twice, the second time every step again from a saved state, and compare.

    The episodes are those of a copy, so that the environment stays as it is. A task that remembers something outside its
    counters, keeps something from the episode before, or draws random numbers in `begin` or `judge` is refused by name.
    Branches that the episode does not enter are not seen: choose `steps` and `seed` so that it does.

    Args:
        env: the task's environment, such as `ComponentEnv(component, task)`.
        steps: the largest number of control steps.
        seed: of the episode and the actions.

    Returns:
        The number of actions played.

    Raises:
        ParameterError: the two episodes differ; names the action and the entry of the info.
    """
    one = getattr(env, "unwrapped", None)
    if not isinstance(one, ComponentEnv):
        expected = "the environment of one task, such as ComponentEnv(component, task)"
        raise ParameterError(f"got {one_line(env)}", expected=expected, at="env")
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, *(one.action_space.shape or ())))
    twin = copy.deepcopy(one)
    first = dict(_transcript(twin, actions, seed, 1))
    for number, found in _transcript(twin, actions, seed, 2):
        for name, value in first[number].items():
            if np.asarray(value).tobytes() != np.asarray(found.get(name)).tobytes():
                raise ParameterError(
                    f"got {one_line(found.get(name))} after action {number}, where the same episode gave {one_line(value)}",
                    hint="keep all that the task remembers in counters, set them in begin, and draw in start alone",
                    at=name,
                    source=f"task {one.task.name!r}",
                )
    return max(first)


def _transcript(env: ComponentEnv, actions: np.ndarray, seed: int, attempts: int) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield what an agent gets of the reset (0), and `attempts` times of each action, always from the same saved state."""
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
