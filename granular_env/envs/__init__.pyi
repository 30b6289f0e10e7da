from .environment import ComponentEnv
from .factory import Options, environment_factory
from .policies import Constant, OpenLoop
from .state import EnvState
from .task import RowTask, Task
from .vector_environment import ComponentVectorEnv, make_batch

__all__ = [
    "ComponentEnv",
    "ComponentVectorEnv",
    "Constant",
    "EnvState",
    "OpenLoop",
    "Options",
    "RowTask",
    "Task",
    "environment_factory",
    "make_batch",
]
