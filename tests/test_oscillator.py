"""The toy component against its exact solution."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granular_env.components.errors import ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.profiles import Profile


def error_at_one_period(step_size: float) -> float:
    """Return the phase-space distance from cos(omega t) after one period."""
    oscillator = Oscillator(mass=1.0, stiffness=4.0 * math.pi**2, step_size=step_size)  # period 1 s
    oscillator.reset(position=1.0)
    oscillator.step(1.0)
    return math.hypot(oscillator.get("position") - 1.0, oscillator.get("velocity") / (2.0 * math.pi))


def test_it_is_of_second_order() -> None:
    errors = [error_at_one_period(h) for h in (0.01, 0.005, 0.0025)]
    # Leapfrog's phase leads by a relative (omega h)^2 / 24, i.e. 2 pi (2 pi 0.01)^2 / 24 = 1.03e-3 after a period.
    assert errors[0] == pytest.approx(1.03e-3, rel=0.02)
    for coarse, fine in zip(errors, errors[1:], strict=False):
        assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)


def test_its_energy_stays_within_the_bound_of_the_integrator() -> None:
    oscillator = Oscillator(step_size=0.1)
    oscillator.reset(position=1.0)
    energies = []
    for _ in range(1000):
        oscillator.step(0.1)
        energies.append(oscillator.get("kinetic_energy") + oscillator.get("potential_energy"))
    # Leapfrog conserves E - (omega h)^2 m v^2 / 8, so E rises by a relative (omega h)^2 / 4 at most; this rise is reached.
    assert max(energies) - 0.5 == pytest.approx(0.5 * 0.1**2 / 4, rel=0.01)
    assert min(energies) == pytest.approx(0.5, rel=1e-4)


def test_a_constant_force_on_a_free_body_is_exact() -> None:
    body = Oscillator(mass=2.0, stiffness=0.0, step_size=0.5)
    body.step(4.0, force=3.0)
    assert body.get("velocity") == 6.0
    assert body.get("position") == 12.0
    assert body.get("input_work") == 36.0
    assert body.get("impulse") == 12.0


def test_a_constant_force_displaces_the_middle_of_the_oscillation() -> None:
    oscillator = Oscillator(mass=1.0, stiffness=4.0, step_size=0.001)
    positions = []
    for _ in range(3142):  # one period, pi s
        oscillator.step(0.001, force=2.0)
        positions.append(oscillator.get("position"))
    assert np.mean(positions) == pytest.approx(2.0 / 4.0, rel=1e-3)
    assert max(positions) == pytest.approx(2.0 * 2.0 / 4.0, rel=1e-5)


def test_a_profile_ends_where_it_should() -> None:
    body = Oscillator(mass=1.0, stiffness=0.0, step_size=0.01)
    body.step(1.0, force=Profile.triangle(4.0, 0.5))
    # The midpoint rule is exact for a linear profile: half of 4 N x 0.5 s.
    assert body.get("velocity") == pytest.approx(1.0, rel=1e-14)
    assert body.get("force") == 0.0


def test_wrong_parameters_name_themselves() -> None:
    for name, value in {"mass": 0.0, "stiffness": -1.0, "step_size": 0.0}.items():
        with pytest.raises(ParameterError, match=f"{name}: got"):
            Oscillator(**{name: value})
    with pytest.raises(ParameterError, match="did you mean 'stiffness'"):
        Oscillator(stifness=1.0)
