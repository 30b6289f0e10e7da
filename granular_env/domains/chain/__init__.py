"""The chain of grains: its environments and tasks, their native batch, measurements, gradients, and its paper's atlas."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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

# Gymnasium and numba take a while to import: these come when they are asked for.
_HOMES = {
    "AbsorptionEnv": ".tasks.absorption",
    "AbsorptionTask": ".tasks.absorption",
    "ChainEnv": ".envs.environment",
    "ChainTask": ".envs.task",
    "ChainVectorEnv": ".envs.vector_env",
    "EnergyDeliveryEnv": ".tasks.energy_delivery",
    "EnergyDeliveryTask": ".tasks.energy_delivery",
    "PistonEnv": ".tasks.piston",
    "PistonTask": ".tasks.piston",
    "ProtectionEnv": ".tasks.protection",
    "ProtectionTask": ".tasks.protection",
    "PulseFormingEnv": ".tasks.pulse_forming",
    "PulseFormingTask": ".tasks.pulse_forming",
    "SolitonTrainEnv": ".tasks.soliton_train",
    "SolitonTrainTask": ".tasks.soliton_train",
    "check_task": ".envs.task_check",
}

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


def __getattr__(name: str) -> Any:
    if name == "measurement":
        return import_module(f"{__name__}.measurement")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name], __name__), name)
