"""The check of a task of one's own: a random episode, its kernels uncompiled on arrays that notice a wrong index or write."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from granular_env.components.errors import ParameterError, one_line
from granular_env.envs.environment import ComponentEnv

from .bounds_check import SlipError, UncheckedError, guard_copy
from .environment import ChainEnv


def check_task(env: gymnasium.Env[Any, Any], *, steps: int = 200, seed: int = 0) -> int:
    """Play one episode of random actions with a task's kernels as plain Python on arrays that notice what is wrong.

    The physics, the start and the actions are those of the environment, which itself stays as it is. The kernels and all jitted
    functions that they call run uncompiled: an index beyond counters, constants, inputs or the chain, a negative one in the
    table, and a write into anything but the counters are refused by name, as is a reward that is no finite number. Branches
    that the episode does not enter are not seen: choose `steps` and `seed` so that it does.

    Args:
        env: the task's environment, such as `ChainEnv(chain, task)`.
        steps: the largest number of control steps.
        seed: of the episode and the actions.

    Returns:
        The control steps played.

    Raises:
        ParameterError: there is a slip; names the kernel, the array and the index. Or a kernel does not run as plain Python.
    """
    one = getattr(env, "unwrapped", None)
    if not isinstance(one, ComponentEnv):
        raise ParameterError(
            f"got {one_line(env)}", expected="the environment of one task, such as ChainEnv(chain, task)", at="env"
        )
    copy: Any = guard_copy(one) if isinstance(one, ChainEnv) else one
    before = None if copy is not one else one.save()
    random = np.random.default_rng(seed)
    try:
        return _play(copy, steps, seed, random)
    except SlipError as slip:
        raise ParameterError(str(slip), source=f"task {one.task.name!r}") from None
    except UncheckedError as error:
        raise ParameterError(f"could not be checked: {error}", source=f"task {one.task.name!r}") from error
    finally:
        if before is not None:
            one.restore(before)


def _play(env: Any, steps: int, seed: int, random: np.random.Generator) -> int:
    env.reset(seed=seed)
    for step in range(steps):
        _, _, terminated, truncated, _ = env.step(random.uniform(-1.0, 1.0, env.action_space.shape))
        if terminated or truncated:
            return step + 1
    return steps
