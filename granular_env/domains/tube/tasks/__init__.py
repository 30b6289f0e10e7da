"""Tasks on a tube with a detonation in it, one a file. Each is registered by its line in `ENVIRONMENTS`."""

from __future__ import annotations

from granular_env.domains import Environment

# The threshold is what theory returns, rounded down. There is no native batch: Gymnasium's own serves.
ENVIRONMENTS = {
    "granular_env/Relief-v1": Environment(f"{__name__}.relief:make_relief", 0.6),
}
