from . import domains, viewing
from .components.catalogue import make
from .components.chain import Chain
from .components.component import Component
from .components.errors import (
    ExperimentError,
    GranularError,
    GranularWarning,
    LogError,
    MissingExtraError,
    ParameterError,
    StepError,
    SweepError,
)
from .components.materials.elastic import Material
from .components.profiles import Profile
from .components.snapshot import Snapshot
from .components.variables import Variable
from .control.runner import run_study
from .log_runs import resume
from .recording import open_log, record, recover, verify
from .run_loop import run
from .sweep import open_sweep, run_sweep

__all__ = [
    "Chain",
    "Component",
    "ExperimentError",
    "GranularError",
    "GranularWarning",
    "LogError",
    "Material",
    "MissingExtraError",
    "ParameterError",
    "Profile",
    "Snapshot",
    "StepError",
    "SweepError",
    "Variable",
    "domains",
    "make",
    "open_log",
    "open_sweep",
    "record",
    "recover",
    "resume",
    "run",
    "run_study",
    "run_sweep",
    "verify",
    "viewing",
]
