"""Search methods, one per file: each defines its options (a [[method]] table of the study's file) and its search."""

from .evolution import Evolution
from .gradient import Gradient
from .method import MethodTable
from .random_search import RandomSearch
from .reinforcement_learning import PPO, SAC

AnyMethod = Gradient | Evolution | RandomSearch | PPO | SAC

__all__ = ["AnyMethod", "MethodTable"]
