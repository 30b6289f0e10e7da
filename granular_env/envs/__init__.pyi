from .environment import ComponentEnv
from .policies import Constant, OpenLoop
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
]
