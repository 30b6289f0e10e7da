"""Gymnasium environments: any component x a task.

``import granular_env`` registers ``granular_env/Piston-v0`` and ``granular_env/Force-v0``. An environment of your own is a
component, a `Task` and ``ComponentEnv(component, task)``; a task is one file in ``tasks/``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .registration import register_all, register_when_imported

if TYPE_CHECKING:
    from .chain_environment import ChainEnv
    from .chain_task import ChainTask
    from .environment import ComponentEnv
    from .recording import RecordEnv
    from .state import EnvState
    from .task import Task
    from .tasks.force import ForceEnv, ForceTask
    from .tasks.piston import PistonEnv, PistonTask
    from .vector import ChainVectorEnv

# Gymnasium takes a while to import: these come when they are asked for.
_HOMES = {
    "ChainEnv": ".chain_environment",
    "ChainTask": ".chain_task",
    "ChainVectorEnv": ".vector",
    "ComponentEnv": ".environment",
    "EnvState": ".state",
    "ForceEnv": ".tasks.force",
    "ForceTask": ".tasks.force",
    "PistonEnv": ".tasks.piston",
    "PistonTask": ".tasks.piston",
    "RecordEnv": ".recording",
    "Task": ".task",
}

__all__ = [
    "ChainEnv",
    "ChainTask",
    "ChainVectorEnv",
    "ComponentEnv",
    "EnvState",
    "ForceEnv",
    "ForceTask",
    "PistonEnv",
    "PistonTask",
    "RecordEnv",
    "Task",
    "register_all",
    "register_when_imported",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name], __name__), name)
