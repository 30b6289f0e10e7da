"""Environments by the names that studies call them: ``pulse-forming`` is ``granular_env/PulseForming-v1``."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from granular_env.components.errors import ParameterError, nearest
from granular_env.envs.registration import ENVIRONMENTS


def task_names() -> dict[str, str]:
    """Short name -> registered name."""
    return {_short(registered): registered for registered in ENVIRONMENTS}


def _short(registered: str) -> str:
    plain = registered.rpartition("/")[2].partition("-v")[0]
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", plain).lower()


def registered_name(name: str) -> str:
    """The registered name behind a short or a registered one; `ParameterError` with the nearest for any other."""
    names = task_names()
    if name in ENVIRONMENTS:
        return name
    if name not in names:
        raise ParameterError(f"name: got {name!r}, which is no task; {nearest(name, names)}")
    return names[name]


def make_environment(name: str, arguments: Mapping[str, Any]) -> Any:
    """The single environment of that name, bare.

    Raises:
        ParameterError: it does not take one of the arguments; the nearest is named.
    """
    module, _, kind = ENVIRONMENTS[registered_name(name)].partition(":")
    made = getattr(import_module(module), kind)
    if unknown := [key for key in arguments if key not in (known := _arguments(made))]:
        raise ParameterError(f"{unknown[0]}: unknown; {nearest(unknown[0], known)}")
    return made(**arguments)


def _arguments(kind: Any) -> list[str]:
    """Names that an environment's constructor takes, those of its `Unpack`-ed options included."""
    names: list[str] = []
    for parameter in list(inspect.signature(kind.__init__).parameters.values())[1:]:
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            from granular_env.envs.chain_environment import ChainOptions

            names += list(ChainOptions.__annotations__)
        else:
            names.append(parameter.name)
    return names
