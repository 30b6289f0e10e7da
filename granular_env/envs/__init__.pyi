from .environment import ComponentEnv
from .policies import Constant, OpenLoop
from .registration import register_all, register_when_imported
from .state import EnvState
from .task import Task
from .wrappers import RecordEnv

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
