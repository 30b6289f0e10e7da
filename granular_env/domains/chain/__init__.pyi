from . import control, measurement
from .envs.environment import ChainEnv
from .envs.task import ChainTask
from .envs.task_check import check_task
from .envs.vector_environment import ChainVectorEnv

__all__ = ["ChainEnv", "ChainTask", "ChainVectorEnv", "check_task", "control", "measurement"]
