from . import control, measurement
from .rows import ChainRows

__all__ = ["ChainRows", "control", "measurement"]
