"""Control of chains: exact gradients, objectives, and the checks of both.

    value, gradient = control.value_and_grad(control.total(chain, control.velocity(-1).at_end()), chain, drive, ticks=3)

An objective is a sum of terms, `total`; a term is a quantity of the chain (`velocity`, `energy`, ...) at the end, over a
window of time, or at its peak. The objective of a registered task will do as well.
"""

from __future__ import annotations

import lazy_loader

# The names of __init__.pyi: numba takes a while to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
