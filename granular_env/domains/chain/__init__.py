"""The chain of grains: its native batch of environments, tasks, measurements, gradients and views."""

from __future__ import annotations

import lazy_loader

# The names of __init__.pyi: Gymnasium and numba take a while to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
