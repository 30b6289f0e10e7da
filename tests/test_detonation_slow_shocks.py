"""Shocks that hardly move in the tube: how large the waves are that they leave behind, by limiter, and the caution of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.gas_tools import air_tube, detonating_tube, run_for, sod_tube

from granular_env.components.detonation import DetonationTube

CELLS, PLACE, GAMMA = 200, 0.3, 1.4


def tube_with_shock(mach: float, part: float, limiter: str) -> tuple[DetonationTube, float, float]:
    """Return a tube with a shock that runs into gas on its right, the pressure behind it, and its speed in the tube.

    Args:
        mach: of the shock in the gas ahead, whose density and pressure are 1.
        part: speed in the tube over that in the gas ahead.
        limiter: of slopes.
    """
    through = mach * math.sqrt(GAMMA)
    pressure = 1.0 + 2.0 * GAMMA / (GAMMA + 1.0) * (mach**2 - 1.0)
    density = (GAMMA + 1.0) * mach**2 / ((GAMMA - 1.0) * mach**2 + 2.0)
    ahead = (part - 1.0) * through
    behind = ahead + (1.0 - 1.0 / density) * through
    regions = [
        {"x": [0.0, PLACE], "pressure": pressure, "temperature": pressure / density, "velocity": behind},
        {"x": [PLACE, 1.0], "pressure": 1.0, "temperature": 1.0, "velocity": ahead},
    ]
    fastest = max(abs(behind) + math.sqrt(GAMMA * pressure / density), abs(ahead) + math.sqrt(GAMMA))
    tube = air_tube(
        CELLS, left="absorbing", right="absorbing", regions=regions, limiter=limiter, step_size=0.4 / CELLS / fastest
    )
    return tube, pressure, part * through


def waves_behind(mach: float, part: float, limiter: str) -> float:
    """Return the largest deviation of the pressure behind a shock that has crossed 20 cells, over that pressure."""
    tube, pressure, speed = tube_with_shock(mach, part, limiter)
    run_for(tube, 20.0 / CELLS / speed)
    behind = tube.centres < PLACE + speed * tube.time - 4.5 / CELLS
    return float(np.abs(tube.get("pressure")[behind] / pressure - 1.0).max())


@pytest.mark.parametrize("mach", [3.0, 10.0])
@pytest.mark.parametrize("part", [0.03, 0.1])
def test_waves_behind_slow_shocks_by_limiter(mach: float, part: float) -> None:
    steep, flat, none = (waves_behind(mach, part, limiter) for limiter in ("monotonized_central", "minmod", "first_order"))
    assert none < 2e-3 and flat < 0.02 and flat < 0.7 * steep < 0.7 * 0.05


def test_a_slow_strong_shock_is_warned_of() -> None:
    tube, _, speed = tube_with_shock(10.0, 0.03, "monotonized_central")
    run_for(tube, 20.0 / CELLS / speed)
    assert "a strong shock at 0.39" in tube.cautions()[0] and "minmod" in tube.cautions()[0]
    for mach, part, limiter in ((10.0, 0.03, "minmod"), (10.0, 0.5, "monotonized_central"), (1.2, 0.03, "monotonized_central")):
        tube, _, speed = tube_with_shock(mach, part, limiter)
        run_for(tube, 20.0 / CELLS / speed)
        assert tube.cautions() == []


def test_shocks_that_run_and_their_reflections_are_not_warned_of() -> None:
    sod = sod_tube(CELLS)
    run_for(sod, 0.2)
    assert sod.cautions() == []
    burning = detonating_tube(cells=300, length=0.6)
    for _ in range(20):
        run_for(burning, 2e-5)
        assert burning.cautions() == []
