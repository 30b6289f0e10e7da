"""Gymnasium environments of any component with a task. Importing this package registers the environments of all domains.

A custom environment consists of a component and a `Task`: ``ComponentEnv(component, task)``.
"""

from __future__ import annotations

import lazy_loader
from gymnasium.envs.registration import register, registry

from ..domains import load_environments

# Load the names of __init__.pyi lazily.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

for _name, _one in load_environments().items():
    if _name not in registry:
        # No time limit, because the environment ends its episodes at its deadline.
        register(
            _name,
            entry_point=_one.entry_point,
            vector_entry_point=f"granular_env.envs.vector_environment:{_one.entry_point.partition(':')[2]}",
            reward_threshold=_one.reward_threshold,
        )
