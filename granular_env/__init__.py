"""Wave and fracture experiments in granular and heterogeneous media, as stepping components."""

from __future__ import annotations

import lazy_loader

from .envs.registration import register_when_imported

# The names of __init__.pyi. They come when they are asked for: numba alone takes most of a second to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

register_when_imported()
