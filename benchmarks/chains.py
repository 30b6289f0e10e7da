"""The chains of the benchmarks."""

from __future__ import annotations

from typing import Any

import numpy as np

import granular_env as ge
from granular_env.components.chain.theory import time_scale

RADIUS = 3e-3
SPEED = 5.0
# The paper's contact: A = 5.6e12 N/(m^1.5 kg) times a grain's mass.
MASS = 4.0 / 3.0 * np.pi * RADIUS**3 * 7800.0
STIFFNESS = 5.6e12 * MASS
TAU = time_scale(MASS, STIFFNESS, SPEED)


def precompressed_chain(grains: int, left: str = "plane", **parameters: Any) -> Any:
    """Return a chain precompressed by 100 N with all grains moving, so that every contact is closed and moves."""
    chain = ge.make(
        "chain", grains=grains, radius=RADIUS, material="steel", precompression=100.0, left=left, right="plane", **parameters
    )
    chain.reset(velocity=np.random.default_rng(1).uniform(-0.01, 0.01, grains))
    return chain


def struck_chain(grains: int, **parameters: Any) -> Any:
    """Return the chain of Nesterenko (1983), section 3.1: one grain strikes a touching chain at rest."""
    chain = ge.make("chain", grains=grains, radius=RADIUS, material="steel", contact_stiffness=STIFFNESS, **parameters)
    chain.reset(velocity={0: SPEED})
    return chain


def crossing_ticks(chain: Any) -> int:
    """Return the approximate travel time in ticks of the struck chain's wave to its last grains (0.84 grains per tau)."""
    return max(1, int(chain.parameters.grains * TAU / chain.step_size))
