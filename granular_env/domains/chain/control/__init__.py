"""Optimal control of chains: objectives, their exact gradients, and checks of both.

    value, gradient = control.value_and_grad(control.total(chain, control.velocity(-1).at_end()), chain, drive, ticks=3)

An objective is a sum of terms, `total`; a term is a quantity of the chain (`velocity`, `energy`, ...) at the end, over a
time window, or at its peak. The objective of a registered task can be used instead.
"""

from __future__ import annotations

import lazy_loader

# Load the names of __init__.pyi lazily: numba is slow to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
