"""Logs (files with the recorded history of a component): record, open, run again, branch and repair them."""

import lazy_loader

# Load the names of __init__.pyi lazily, because recording a run needs no code that reads logs.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
