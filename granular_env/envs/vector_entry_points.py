"""The batch of each registered environment: an attribute with the name of the environment's factory."""

from __future__ import annotations

from functools import partial
from typing import Any

import gymnasium
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from granular_env.domains import environments, load


def __getattr__(name: str) -> Any:
    for registered, one in environments().items():
        if one.entry_point.partition(":")[2] == name:
            return partial(_sync_batch, registered) if one.batch is None else partial(load(one.batch), load(one.entry_point))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _sync_batch(
    registered: str, num_envs: int = 1, *, autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP, **arguments: Any
) -> SyncVectorEnv:
    """Return Gymnasium's own batch, with the arguments that native batches take."""
    make = partial(gymnasium.make, registered, **arguments)
    return SyncVectorEnv([make] * num_envs, autoreset_mode=autoreset_mode)
