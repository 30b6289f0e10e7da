"""Tasks on a tube with a detonation, one per file. `ENVIRONMENTS` registers them."""

from __future__ import annotations

from granular_env.domains import Environment

# The reward threshold is the return of the "theory" baseline, rounded down. Batches are Gymnasium's vector environments.
ENVIRONMENTS = {
    "granular_env/Relief-v1": Environment(f"{__name__}.relief:make_relief", 0.6),
}
