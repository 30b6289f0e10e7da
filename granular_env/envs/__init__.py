"""Gymnasium environments: any component with a task. Importing this package registers those that the domains offer.

An environment of your own is a component, a `Task` and ``ComponentEnv(component, task)``.
"""

from __future__ import annotations

import lazy_loader

from .registration import register_all

# The names of __init__.pyi.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

register_all()
