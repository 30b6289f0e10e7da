"""Tasks on a grid, one per file. `ENVIRONMENTS` registers them."""

from __future__ import annotations

from granular_env.domains import Environment

# The reward threshold is just below the return of the best drive, which is known from linear theory.
ENVIRONMENTS = {
    "granular_env/BuriedTarget-v1": Environment(f"{__name__}.buried_target:make_buried_target", 0.99),
}
