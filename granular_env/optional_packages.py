"""Lazy imports of optional packages, with an install hint if one is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from granular_env.components.errors import MissingExtraError

_INSTALL = {
    "rerun": ("rerun-sdk", "pip install 'granular-env[view]'"),
    "matplotlib": ("matplotlib", "pip install 'granular-env[view]'"),
    "pandas": ("pandas", "pip install 'granular-env[sweep]'"),
    "ray": ("ray", "pip install 'granular-env[ray]'"),
    "cma": ("cma", "pip install 'granular-env[control]'"),
    "torch": ("torch", "pip install 'granular-env[rl]'"),
    "stable_baselines3": ("stable-baselines3", "pip install 'granular-env[rl]'"),
    "xarray": ("xarray", "pip install 'granular-env[data]'"),
    "h5netcdf": ("h5netcdf", "pip install 'granular-env[data]'"),
    "h5py": ("h5py", "pip install 'granular-env[data]'"),
    "pyevtk": ("pyevtk", "pip install 'granular-env[data]'"),
    "imageio_ffmpeg": ("imageio-ffmpeg", "pip install 'granular-env[video]'"),
}


def import_optional(module: str, purpose: str) -> Any:
    """Import the module and return it.

    Raises:
        MissingExtraError: it is not installed; the message contains the install command.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package, command = _INSTALL[module.partition(".")[0]]
        raise MissingExtraError(
            f"{purpose} needs the package {package}, which cannot be imported ({error})", hint=f"run: {command}"
        ) from None
