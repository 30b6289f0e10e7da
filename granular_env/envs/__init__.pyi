from .environment import ComponentEnv
from .policies import Constant, OpenLoop
from .recording_wrapper import RecordEnv
from .state import EnvState
from .task import Task
from .task_check import check_task

__all__ = [
    "ComponentEnv",
    "Constant",
    "EnvState",
    "OpenLoop",
    "RecordEnv",
    "Task",
    "check_task",
]
