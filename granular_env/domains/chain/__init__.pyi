from . import measurement
from .envs.environment import ChainEnv
from .envs.task import ChainTask
from .envs.task_check import check_task
from .envs.vector_env import ChainVectorEnv
from .tasks.absorption import AbsorptionEnv, AbsorptionTask
from .tasks.energy_delivery import EnergyDeliveryEnv, EnergyDeliveryTask
from .tasks.piston import PistonEnv, PistonTask
from .tasks.protection import ProtectionEnv, ProtectionTask
from .tasks.pulse_forming import PulseFormingEnv, PulseFormingTask
from .tasks.soliton_train import SolitonTrainEnv, SolitonTrainTask

__all__ = [
    "AbsorptionEnv",
    "AbsorptionTask",
    "ChainEnv",
    "ChainTask",
    "ChainVectorEnv",
    "EnergyDeliveryEnv",
    "EnergyDeliveryTask",
    "PistonEnv",
    "PistonTask",
    "ProtectionEnv",
    "ProtectionTask",
    "PulseFormingEnv",
    "PulseFormingTask",
    "SolitonTrainEnv",
    "SolitonTrainTask",
    "check_task",
    "measurement",
]
