"""Section 3.5: chains of random radii (R0 + RAND) mm, many draws of them. The paper has one of each, and it is not known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Curve
from granular_env.atlas.seed_statistics import Band
from granular_env.components.chain.arrangements.random_radii import draw_radii
from granular_env.components.chain.radius_distribution import UniformRadii
from granular_env.components.errors import GranularError

from .. import measurement
from ..measurement import History
from .cases import RADIUS, SPEED, case_document, grain, length
from .wave_count import CLEAR

SEEDS = 100
# So many of them have logs; the others can be made again from their seeds.
LOGGED = 20
# Draws of the item that compares two means, for each of the others.
MANY = 4
# Steps of the integrator [s]: at twice that velocities differ by less than 1e-4 v0, and statistics by nothing that is printed.
_STEP = 1e-7
# For frames that are written [s].
_WRITTEN = 1e-4
# A front runs at about so much [m/s]; weaker ones are slower.
_PACE = {"3.5a-random-piston": 550.0, "3.5b-random-free": 400.0}
# The front is where a grain first moves so fast.
FRONT = 0.1 * SPEED


# A velocity beside the piston is uneven, as we read it.
UNEVEN = f"more than {100.0 * CLEAR:g} % of v0 in 95 % of the draws"
UNEVEN_REASON = f"The paper does not say how uneven; {UNEVEN} is our reading."

# Why a number of the paper's may stand outside of all draws.
OUTSIDE = "The paper’s number is of one draw, which is not known; none of ours reaches it."


def is_uneven(spread: Band) -> bool:
    """Return whether standard deviations of the velocities beside the piston [% of v0] are such as `UNEVEN` says."""
    return spread.quantile(5) > 100.0 * CLEAR


def seeds(context: Context) -> range:
    """Return the seeds of the draws, from 1."""
    return range(1, int(context.constants["seeds"]) + 1)


def histories(
    context: Context,
    shipped: str,
    smallest: float,
    grains: int,
    duration: float | None = None,
    given: dict[int, float] | None = None,
) -> Iterator[History]:
    """Yield the motion for each seed.

    Args:
        context: of the atlas.
        shipped: the experiment.
        smallest: R0 [mm].
        grains: as in the paper.
        duration: as in the paper [s]; default: until the last grain has left.
        given: radii that the paper tells, by its number of the grain [m].
    """
    for seed in seeds(context):
        content = document(context, shipped, smallest, grains, seed, duration, given)
        yield context.watch(content, sampling(smallest), recorded=seed <= LOGGED)


def sampling(smallest: float) -> float:
    """Return the time between two frames that are measured [s], a tenth of the unit of time, which goes as the radius."""
    return 2e-7 if (smallest + 0.5) * 1e-3 < 0.5 * RADIUS else 5e-7


def document(
    context: Context,
    shipped: str,
    smallest: float,
    grains: int,
    seed: int,
    duration: float | None = None,
    given: dict[int, float] | None = None,
) -> dict[str, Any]:
    """Return one draw as an experiment that writes little; arguments as in `histories`."""
    radius: Any = {"low": smallest * 1e-3, "high": smallest * 1e-3 + 1e-3, "seed": seed}
    if given:
        radii = draw_radii(UniformRadii(**radius), length(context, grains))
        for number, value in given.items():
            radii[grain(context, number)] = value
        radius = radii.tolist()
    found = case_document(
        context, shipped, component__grains=grains, component__radius=radius,
        component__integrator="pefrl", component__step_size=_STEP, record={"every": _WRITTEN, "variables": ["velocity"]},
        name=f"nesterenko-1983/{shipped}-R{smallest:g}-N{grains}-seed{seed}",
    )  # fmt: skip
    if duration is None:
        duration = 2.0 * (smallest + 0.5) * 1e-3 * length(context, grains) / _PACE[shipped]
    found["duration"] = float(np.ceil(duration / _WRITTEN - 1e-9)) * _WRITTEN
    return found


def last_velocities(chain: History) -> tuple[float, float]:
    """Return the last grain's velocity over v0: when it first leaves the chain, and the largest ever, after later waves.

    Raises:
        GranularError: it has not left.
    """
    velocity = chain.velocity[:, -1] / SPEED
    left = (chain.overlap[:, -2] < 0.0) & (velocity > 1e-3)
    if not left.any():
        raise GranularError(f"the last grain has not left the chain at {chain.time[-1]:g} s", hint="the run has to be longer")
    return float(velocity[np.argmax(left)]), float(velocity.max())


def energy_while(chain: History, first: int, last: int) -> measurement.EnergyRatio:
    """Ek/Ep while the front goes from one grain to another, by our count."""
    return measurement.energy_ratio(chain, arrival(chain, first), arrival(chain, last))


def arrival(chain: History, index: int) -> float:
    """Return when a grain first moves as fast as a front does [s], to a frame; infinite where it never does."""
    passed = chain.velocity[:, index] > FRONT
    return float(chain.time[np.argmax(passed)]) if passed.any() else np.inf


def strip(band: Band, row: float, named: bool) -> list[Curve]:
    """Return a band as drawn: a thick line from 5 to 95 %, a dot for each draw, and the mean; `named` for the legend."""
    return [
        Curve("5 to 95 %" if named else "", [band.quantile(5), band.quantile(95)], [row, row], "bar", 0),
        Curve("draws" if named else "", band.draws, np.full(band.count, row), "points", 5),
        Curve("mean" if named else "", [band.mean], [row], "points", 1),
    ]


def envelope(x: np.ndarray, draws: np.ndarray) -> Curve:
    """Return where 90 % of the draws lie, as two faint lines.

    Args:
        x: shape (points,).
        draws: shape (seeds, points).
    """
    low, high = np.percentile(draws, (5, 95), axis=0)
    gap = [np.nan]
    return Curve("5 and 95 % of the draws", np.concatenate([x, gap, x]), np.concatenate([low, gap, high]), "thin", 1)
