"""The native batch of each registered environment of a chain: an attribute with the name of the environment's factory."""

from __future__ import annotations

from functools import partial
from typing import Any

from granular_env.domains import load

from ..tasks import ENVIRONMENTS


def __getattr__(name: str) -> Any:
    for environment in ENVIRONMENTS.values():
        if environment.entry_point.partition(":")[2] == name:
            from .vector_environment import ChainVectorEnv

            return partial(ChainVectorEnv, load(environment.entry_point))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
