"""Registration of the environments with Gymnasium."""

from __future__ import annotations


def register_all() -> None:
    """Register every environment of this package; those that are registered already stay as they are."""
    from gymnasium.envs.registration import register, registry

    from ..domains import environments

    for name, one in environments().items():
        if name not in registry:
            # No time limit: the environment ends its episodes itself at its deadline, and its own `spec` says when.
            register(
                name,
                entry_point=one.entry_point,
                vector_entry_point=f"granular_env.envs.vector_environment:{one.entry_point.partition(':')[2]}",
                reward_threshold=one.reward_threshold,
            )
