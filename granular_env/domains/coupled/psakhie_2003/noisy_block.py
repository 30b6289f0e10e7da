"""A small block, half grid and half automata, that starts in noisy motion: an unstable scheme shows itself there."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.experiments import load_experiment

# Cells of 2.5 mm: so many along the grid and across it.
SIZE, ALONG, ACROSS = 2.5e-3, 16, 8
# A standing wave, and 5 % of it as noise [m/s].
_VELOCITY, _NOISE, _SEED = 0.1, 0.05, 3


def noisy_block(context: Context, smaller: int, scheme: str, micro_steps: int, step: float, ticks: int) -> dict[str, Any]:
    """Return the experiment of figure 6, on a small block that nothing drives.

    Args:
        context: of the atlas; its refinement divides the step.
        smaller: n, of the automata's diameter, cell / n.
        scheme: how nodes of the interface move.
        micro_steps: steps of the automata in one of the grid.
        step: of the grid [s].
        ticks: how many of them.
    """
    found = load_experiment("psakhie-2003/plane-wave-coupled").to_dict()
    component = found["component"]
    component["grid"]["mesh"] |= {"columns": ALONG, "rows": ACROSS, "cell_size": SIZE}
    component["grid"]["receivers"] = []
    component["automata"]["shape"] |= {"width": ALONG * SIZE, "height": ACROSS * SIZE}
    component["automata"]["diameter"] = SIZE / smaller
    component |= {"origin": [ALONG * SIZE, 0.0], "scheme": scheme, "micro_steps": micro_steps}
    component["step_size"] = step / context.refinement
    found["input"] = {}
    found["start"] = {"grid_velocity": _velocities().tolist()}
    found["duration"] = ticks * step
    found["record"] = {"every": 10.0 * step, "variables": ["grid_velocity", "automata_velocity"]}
    return found


def _velocities() -> Any:
    """Return velocities of the nodes: half a wave along x, and noise; shape (nodes, 2) [m/s]."""
    x = np.tile(np.arange(ALONG + 1), ACROSS + 1)
    noise = _VELOCITY * _NOISE * np.random.default_rng(_SEED).standard_normal((len(x), 2))
    noise[:, 0] += _VELOCITY * np.sin(np.pi * x / ALONG)
    return noise
