"""The shipped experiments with contact laws show the stated results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from support.chain_tools import MASS, SPEED

import granular_env as ge
from granular_env.components.chain import theory
from granular_env.domains.chain import measurement

pytestmark = pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")


def watched(name: str, every: float, overrides: Mapping[str, Any] | None = None):
    """Run an experiment; return its chain and history."""
    watch = measurement.Watch(every)
    result = ge.run(name, observers=[watch], overrides=overrides or {})
    return result.component, watch.history


def test_a_weakly_dissipative_piston_front_runs_at_d1():
    """Conservation determines D1; the front becomes steady within 50 grains, and loses 10 % of the energy."""
    d1 = theory.shock_speed(constant=5.6e12, diameter=6e-3, piston=SPEED)
    chain, history = watched("laws/dissipative-piston", 1e-6)
    speeds = [measurement.front_speed(history, 0.5 * SPEED, first, first + 50) for first in (50, 100)]
    assert speeds == pytest.approx([d1, d1], rel=1e-3)
    assert abs(speeds[1] - d1) < abs(speeds[0] - d1)
    balances = chain.balance_values()
    assert balances["dissipated_energy"] / balances["input_work"] == pytest.approx(0.0977, abs=1e-3)
    # Second-order in the step, 1.1e-4 at 0.5 us.
    assert abs(balances["energy_residual"]) < 2e-4 * balances["input_work"]
    _, lossless = watched("laws/dissipative-piston", 1e-6, {"component.law": "hertz"})
    assert measurement.front_speed(lossless, 0.5 * SPEED, 50, 100) / d1 == pytest.approx(1.04, abs=0.005)


def test_less_dissipation_leaves_the_front_higher_and_as_fast():
    d1 = theory.shock_speed(constant=5.6e12, diameter=6e-3, piston=SPEED)
    heights = []
    for dissipation in (1e3, 2e3, 4e3):
        _, history = watched("laws/dissipative-piston", 1e-6, {"component.law.dissipation": dissipation})
        assert measurement.front_speed(history, 0.5 * SPEED, 100, 150) == pytest.approx(d1, rel=1e-3)
        heights.append(history.velocity[:, 140].max() / SPEED)
    assert 2.0 > heights[0] > heights[1] > heights[2] > 1.0


def test_a_plastic_chain_wears_the_wave_down():
    chain, history = watched("laws/plastic-impact", 1e-6)
    heights = history.velocity.max(axis=0)
    assert (np.diff(heights[1:-1]) < 0.0).all()
    assert heights[55] < 0.1 * SPEED
    balances = chain.balance_values()
    energy = 0.5 * chain.geometry.mass[0] * SPEED**2
    assert balances["dissipated_energy"] > 0.9 * energy
    assert abs(balances["energy_residual"]) < 1e-5 * energy
    _, elastic = watched("laws/plastic-impact", 1e-6, {"component.law": "hertz"})
    assert elastic.velocity[:, 55].max() == pytest.approx(0.6816 * SPEED, rel=1e-3)


def test_a_column_rests_until_it_is_tapped_and_carries_the_pulse_faster_the_deeper():
    chain, history = watched("laws/vertical-chain", 5e-6)
    weight = MASS * 9.81
    np.testing.assert_allclose(history.contact_force[0, 1:], weight * np.arange(1, 101), rtol=1e-12)
    pulses = [measurement.waves_at(history, grain, 1e-3)[0] for grain in (5, 20, 40, 80)]
    assert (np.diff([pulse.speed for pulse in pulses]) > 0.0).all()
    assert (np.diff([pulse.duration for pulse in pulses]) > 0.0).all()
    still, _ = watched("laws/vertical-chain", 5e-6, {"start.velocity": {}})
    assert np.abs(still.get("velocity")).max() < 1e-15
    assert abs(chain.get("energy_residual")) < 1e-6 * 0.5 * MASS * 1e-4
