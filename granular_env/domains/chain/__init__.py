"""The chain of grains: its environments and their native batch, tasks, measurements, gradients, views, and a paper's atlas."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import measurement
    from .envs.environment import ChainEnv
    from .envs.task import ChainTask
    from .envs.task_check import check_task
    from .envs.vector_env import ChainVectorEnv

# Gymnasium and numba take a while to import: these come when they are asked for.
_HOMES = {
    "ChainEnv": ".envs.environment",
    "ChainTask": ".envs.task",
    "ChainVectorEnv": ".envs.vector_env",
    "check_task": ".envs.task_check",
}

__all__ = ["ChainEnv", "ChainTask", "ChainVectorEnv", "check_task", "measurement"]


def __getattr__(name: str) -> Any:
    if name == "measurement":
        return import_module(f"{__name__}.measurement")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name], __name__), name)
