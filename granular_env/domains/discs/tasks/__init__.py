"""Tasks on discs, one a file. Each is registered by its line in `ENVIRONMENTS`."""

from __future__ import annotations

from granular_env.domains import Environment

# The threshold is what theory returns, rounded down. There is no native batch: Gymnasium's own serves.
ENVIRONMENTS = {
    "granular_env/Splitting-v1": Environment(f"{__name__}.splitting:make_splitting", 0.586),
}
