"""Simulations of waves and fracture in granular and heterogeneous media; each model is a component with a method `step`."""

from __future__ import annotations

import sys

import lazy_loader

# Load the names of __init__.pyi lazily: numba alone takes most of a second to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

# Importing Gymnasium takes twenty times as long as this package. `granular_env.envs` registers the environments.
if "gymnasium" in sys.modules:
    from . import envs  # noqa: F401
