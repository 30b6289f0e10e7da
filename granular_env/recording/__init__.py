"""Logs: record a component, open a log, replay, branch and repair it."""

import lazy_loader

# Load the names of __init__.pyi lazily, because recording a run needs no code that reads logs.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
