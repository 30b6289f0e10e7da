"""Gymnasium environments: any component x a task.

``import granular_env`` registers those that the domains offer, ``granular_env/Piston-v1`` for one. An environment of your own
is a component, a `Task` and ``ComponentEnv(component, task)``.
"""

from __future__ import annotations

import lazy_loader

# The names of __init__.pyi: Gymnasium takes a while to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
