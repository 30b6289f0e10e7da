"""Tasks on discs, one per file. `ENVIRONMENTS` registers them."""

from __future__ import annotations

from granular_env.domains import Environment

# The reward threshold is the return of the "theory" baseline, rounded down. Batches are Gymnasium's vector environments.
ENVIRONMENTS = {
    "granular_env/Splitting-v1": Environment(f"{__name__}.splitting:make_splitting", 0.586),
}
