"""Methods, one per file: a table of the study's file with its options and its search."""

from .evolution import Evolution
from .gradient import Gradient
from .method import MethodTable
from .random_search import RandomSearch
from .reinforcement_learning import PPO, SAC

AnyMethod = Gradient | Evolution | RandomSearch | PPO | SAC

__all__ = ["AnyMethod", "MethodTable"]
