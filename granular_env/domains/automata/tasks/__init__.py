"""Tasks on specimens of automata, one per file. `ENVIRONMENTS` registers them."""

from __future__ import annotations

from granular_env.domains import Environment

# The reward threshold is the lowest return of the "theory" baseline over seeds 100 to 199, rounded down. There is no native
# batch; Gymnasium's vector environments are used.
ENVIRONMENTS = {
    "granular_env/Confinement-v3": Environment(f"{__name__}.confinement:make_confinement", -0.104),
}
