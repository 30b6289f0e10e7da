"""Tasks on a grid, one a file: what is rewarded. Each is registered by its line in `ENVIRONMENTS`."""

from __future__ import annotations

from granular_env.domains import Environment

# The threshold is just below what the best drive returns, which linear theory knows.
ENVIRONMENTS = {
    "granular_env/BuriedTarget-v1": Environment(f"{__name__}.buried_target:make_buried_target", 0.99),
}
