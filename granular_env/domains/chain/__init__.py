"""The chain of grains: its native batch of environments, tasks, measurements, gradients and views."""

from __future__ import annotations

import lazy_loader

# Load the names of __init__.pyi lazily: Gymnasium and numba are slow to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
