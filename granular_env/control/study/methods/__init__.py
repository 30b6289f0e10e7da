"""Methods, one a file: a table of the study file, which says what it searches with, and how it searches."""

from __future__ import annotations

from .evolution import Evolution
from .gradient import Gradient
from .method import MethodTable
from .policy_search import PolicySearch
from .random_search import RandomSearch
from .reinforcement_learning import PPO, SAC

AnyMethod = Gradient | Evolution | RandomSearch | PolicySearch | PPO | SAC

__all__ = ["AnyMethod", "MethodTable"]
