"""Tasks on specimens of automata, one a file. Each is registered by its line in `ENVIRONMENTS`."""

from __future__ import annotations

from granular_env.domains import Environment

# The threshold is what theory returns, rounded down, with the least favourable of the strengths that were tried. There is no
# native batch: Gymnasium's own serves.
ENVIRONMENTS = {
    "granular_env/Confinement-v2": Environment(f"{__name__}.confinement:make_confinement", -0.098),
}
