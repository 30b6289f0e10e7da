"""Gymnasium environments: any component x a task.

``import granular_env`` registers those of `registration.ENVIRONMENTS`, ``granular_env/Piston-v1`` for one. An environment of
your own is a component, a `Task` and ``ComponentEnv(component, task)``; a task is one file in ``tasks/``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .registration import register_all, register_when_imported

if TYPE_CHECKING:
    from .environment import ComponentEnv
    from .policies import Constant, OpenLoop
    from .state import EnvState
    from .task import Task
    from .wrappers import RecordEnv

# Gymnasium takes a while to import: these come when they are asked for.
_HOMES = {
    "ComponentEnv": ".environment",
    "Constant": ".policies",
    "EnvState": ".state",
    "OpenLoop": ".policies",
    "RecordEnv": ".wrappers",
    "Task": ".task",
}

__all__ = [
    "ComponentEnv",
    "Constant",
    "EnvState",
    "OpenLoop",
    "RecordEnv",
    "Task",
    "register_all",
    "register_when_imported",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name], __name__), name)
