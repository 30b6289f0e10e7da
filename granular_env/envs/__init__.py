"""Gymnasium environments: any component x a task.

``import granular_env`` registers those of `registration.ENVIRONMENTS`, ``granular_env/Piston-v1`` for one. An environment of
your own is a component, a `Task` and ``ComponentEnv(component, task)``; a task is one file in ``tasks/``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .registration import register_all, register_when_imported

if TYPE_CHECKING:
    from .chain_environment import ChainEnv
    from .chain_task import ChainTask
    from .environment import ComponentEnv
    from .policies import Constant, OpenLoop
    from .recording import RecordEnv
    from .state import EnvState
    from .task import Task
    from .task_check import check_task
    from .tasks.absorption import AbsorptionEnv, AbsorptionTask
    from .tasks.energy_delivery import EnergyDeliveryEnv, EnergyDeliveryTask
    from .tasks.piston import PistonEnv, PistonTask
    from .tasks.protection import ProtectionEnv, ProtectionTask
    from .tasks.pulse_forming import PulseFormingEnv, PulseFormingTask
    from .tasks.soliton_train import SolitonTrainEnv, SolitonTrainTask
    from .vector import ChainVectorEnv

# Gymnasium takes a while to import: these come when they are asked for.
_HOMES = {
    "AbsorptionEnv": ".tasks.absorption",
    "AbsorptionTask": ".tasks.absorption",
    "ChainEnv": ".chain_environment",
    "ChainTask": ".chain_task",
    "ChainVectorEnv": ".vector",
    "ComponentEnv": ".environment",
    "Constant": ".policies",
    "EnergyDeliveryEnv": ".tasks.energy_delivery",
    "EnergyDeliveryTask": ".tasks.energy_delivery",
    "EnvState": ".state",
    "OpenLoop": ".policies",
    "PistonEnv": ".tasks.piston",
    "PistonTask": ".tasks.piston",
    "ProtectionEnv": ".tasks.protection",
    "ProtectionTask": ".tasks.protection",
    "PulseFormingEnv": ".tasks.pulse_forming",
    "PulseFormingTask": ".tasks.pulse_forming",
    "RecordEnv": ".recording",
    "SolitonTrainEnv": ".tasks.soliton_train",
    "SolitonTrainTask": ".tasks.soliton_train",
    "Task": ".task",
    "check_task": ".task_check",
}

__all__ = [
    "AbsorptionEnv",
    "AbsorptionTask",
    "ChainEnv",
    "ChainTask",
    "ChainVectorEnv",
    "ComponentEnv",
    "Constant",
    "EnergyDeliveryEnv",
    "EnergyDeliveryTask",
    "EnvState",
    "OpenLoop",
    "PistonEnv",
    "PistonTask",
    "ProtectionEnv",
    "ProtectionTask",
    "PulseFormingEnv",
    "PulseFormingTask",
    "RecordEnv",
    "SolitonTrainEnv",
    "SolitonTrainTask",
    "Task",
    "check_task",
    "register_all",
    "register_when_imported",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name], __name__), name)
