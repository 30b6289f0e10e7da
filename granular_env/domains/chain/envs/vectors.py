"""Where Gymnasium finds the native batch of each registered environment: an attribute with the environment's class name."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

from granular_env.envs.registration import ENVIRONMENTS


def __getattr__(name: str) -> Any:
    for entry_point in ENVIRONMENTS.values():
        module, _, environment = entry_point.partition(":")
        if environment == name:
            from .vector_env import ChainVectorEnv

            return partial(ChainVectorEnv, getattr(import_module(module), name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
