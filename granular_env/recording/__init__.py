"""Logs: record a component, open the log, re-run it, branch off it, repair it."""

import lazy_loader

# The names of __init__.pyi: what records a run does not read logs.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
