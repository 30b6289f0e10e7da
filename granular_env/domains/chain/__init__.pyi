from . import control, measurement
from .envs.environment import ChainEnv
from .envs.task import ChainTask
from .envs.vector_environment import ChainVectorEnv

__all__ = ["ChainEnv", "ChainTask", "ChainVectorEnv", "control", "measurement"]
