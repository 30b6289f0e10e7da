"""Policies: callables (observation, info) -> action with a memory that `reset` clears.

`Constant` and `OpenLoop` look at nothing; `MatchedPiston` and `MatchedForce` let waves out of a right end, `Dashpot` brakes it
(`env.unwrapped.task.baselines()` has them made for its chain); `play` lets any of them run an episode.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..envs.chain_task import Policy
from ..envs.policies import Constant, OpenLoop
from ..envs.tasks.matched import SENSORS, Dashpot, MatchedForce, MatchedPiston, Sensors

__all__ = ["SENSORS", "Constant", "Dashpot", "MatchedForce", "MatchedPiston", "OpenLoop", "Policy", "Sensors", "play"]


def play(
    env: Any, policy: Policy, *, seed: int | None = None, options: dict[str, Any] | None = None
) -> tuple[float, Mapping[str, Any]]:
    """One episode, from its reset to its end; the return, and the last ``info``.

    Args:
        env: a Gymnasium environment.
        policy: chooses its actions.
        seed: of the reset.
        options: of the reset.
    """
    observation, info = env.reset(seed=seed, options=options)
    policy.reset()
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation, info))
        total, over = total + float(reward), terminated or truncated
    return total, info
