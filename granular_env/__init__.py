"""Wave experiments in granular media, as stepping components."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .envs.registration import register_when_imported

if TYPE_CHECKING:
    from . import domains, viewing
    from .atlas import run_atlas
    from .components.catalogue import make
    from .components.chain import Chain
    from .components.component import Component
    from .components.contract import Variable
    from .components.errors import (
        ExperimentError,
        FmuError,
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
    from .control.study.running import run_study
    from .recording import open_log, record, recover, verify
    from .running import run
    from .sweep import open_sweep, run_sweep

# Public name -> module that it is in; none for a package. They come when they are asked for: numba alone takes most of a second
# to import.
_HOMES = {
    "Chain": "components.chain",
    "Component": "components.component",
    "ExperimentError": "components.errors",
    "FmuError": "components.errors",
    "GranularError": "components.errors",
    "GranularWarning": "components.errors",
    "LogError": "components.errors",
    "Material": "components.materials.elastic",
    "MissingExtraError": "components.errors",
    "ParameterError": "components.errors",
    "Profile": "components.profiles",
    "Snapshot": "components.snapshot",
    "StepError": "components.errors",
    "SweepError": "components.errors",
    "Variable": "components.contract",
    "domains": "",
    "make": "components.catalogue",
    "open_log": "recording",
    "open_sweep": "sweep",
    "record": "recording",
    "recover": "recording",
    "run": "running",
    "run_atlas": "atlas",
    "run_study": "control.study.running",
    "run_sweep": "sweep",
    "verify": "recording",
    "viewing": "",
}

__all__ = [
    "Chain",
    "Component",
    "ExperimentError",
    "FmuError",
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
    "run",
    "run_atlas",
    "run_study",
    "run_sweep",
    "verify",
    "viewing",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if not _HOMES[name]:
        return import_module(f"{__name__}.{name}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


register_when_imported()
