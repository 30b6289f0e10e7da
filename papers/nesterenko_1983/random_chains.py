"""Chains of random radii (R0 + RAND) mm of section 3.5, with many samples each; the paper's single sample is unknown.

Statistics at steps of twice this length agree to the digits shown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes

import granular_env as ge
from chains import CLEAR, SPEED
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History
from pages import Row

SEEDS = range(1, 101)
STEP = 1e-7
# Velocity that defines the front [m/s]; the front runs at about 550 m/s before a piston, 400 m/s in a free chain.
FRONT = 0.1 * SPEED
OUTSIDE = "The paper's numbers are of one unknown sample; the verdict gives their percentile among our samples."
# Our reading of "no even velocity".
UNEVEN = f"more than {100 * CLEAR:g} % of v0 in 95 % of the samples"


def random_chain(smallest: float, grains: int, seed: int, left: str, **given: float) -> ge.Chain:
    """Return a chain of steel grains with radii between `smallest` and `smallest` + 1 mm, in its start state.

    Args:
        smallest: R0 [mm].
        grains: number of grains.
        seed: seed of the sample.
        left: "piston", or "free" for two moving grains.
        given: radii stated in the paper [m], such as ``grain_25=7.8e-4``.
    """
    radius: Any = {"low": 1e-3 * smallest, "high": 1e-3 * smallest + 1e-3, "seed": seed}
    chain = ge.Chain(grains=grains, radius=radius, material="steel", left=left, integrator="pefrl", step_size=STEP)
    if given:
        radii = chain.geometry.radius.tolist()
        for name, value in given.items():
            radii[int(name.removeprefix("grain_")) - 1] = value
        chain = ge.Chain(grains=grains, radius=radii, material="steel", left=left, integrator="pefrl", step_size=STEP)
    chain.reset(velocity={0: SPEED} if left == "piston" else {0: SPEED, 1: SPEED})
    return chain


def duration(smallest: float, grains: int, left: str) -> float:
    """Return the time until the last grain has left [s]."""
    pace = 550.0 if left == "piston" else 400.0
    return math.ceil(2e-3 * (smallest + 0.5) * grains / pace / 1e-4 - 1e-9) * 1e-4


def histories(smallest: float, grains: int, left: str, until: float | None = None, **given: float) -> Iterator[History]:
    """Yield the motion for each seed, until the last grain has left or for a time `until` [s]."""
    every = 2e-7 if smallest < 1.0 else 5e-7
    inputs = {"left_velocity": SPEED} if left == "piston" else {}
    for seed in SEEDS:
        chain = random_chain(smallest, grains, seed, left, **given)
        yield measurement.observe(chain, until or duration(smallest, grains, left), every, **inputs)


def last_velocities(chain: History) -> tuple[float, float]:
    """Return the last grain's velocity over v0 when it first leaves the chain, and its largest velocity after later waves."""
    velocity = chain.velocity[:, -1] / SPEED
    left = (chain.overlap[:, -2] < 0.0) & (velocity > 1e-3)
    assert left.any(), "the last grain has not left the chain; use a longer run"
    return float(velocity[np.argmax(left)]), float(velocity.max())


def arrival_time(chain: History, grain: int) -> float:
    """Return the arrival time of the front at a grain (counted from 1) [s]; infinity if it does not arrive."""
    passed = chain.velocity[:, grain - 1] > FRONT
    return float(chain.time[np.argmax(passed)]) if passed.any() else np.inf


def front_energy_ratio(chain: History, first: int, last: int) -> measurement.EnergyRatio:
    """Return Ek/Ep while the front runs between two grains (counted from 1)."""
    return measurement.energy_ratio(chain, arrival_time(chain, first), arrival_time(chain, last))


def draw_strips(axes: Axes, rows: list[Row]) -> None:
    """Draw a strip per row of samples: dots, a bar from 5 to 95 %, the mean, and the paper's number as a cross."""
    for place, row in zip(range(len(rows), 0, -1), rows, strict=True):
        low, high = np.percentile(row.draws, (5, 95))
        axes.plot([low, high], [place, place], color="C0", linewidth=5, alpha=0.4, label="5 to 95 %" if place == 1 else None)
        axes.plot(row.draws, np.full(len(row.draws), place), ".", color="0.4", label="draws" if place == 1 else None)
        axes.plot(row.ours, place, "o", color="C1", label="mean" if place == 1 else None)
        if row.paper is not None:
            axes.plot(row.number, place, "kx", markersize=9)
    axes.set_yticks(range(len(rows), 0, -1), [row.what for row in rows])
