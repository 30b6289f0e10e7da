"""The gas between pistons against theory: shock, rarefaction, slow compression, and rigid motion of the tube."""

from __future__ import annotations

import numpy as np
import pytest
from support.gas_tools import AIR, advance_tube, air_tube

import granular_env as ge
from granular_env.components.detonation import DetonationTube
from granular_env.components.detonation.theory import Flow, riemann_problem

GAMMA, SOUND = AIR.gamma, AIR.gamma**0.5
REST = Flow(1.0, 0.0, 1.0)


def gas_beside(speed: float) -> tuple[float, float]:
    """Return pressure and density at a piston at the left end, where the contact between a state and its image is the wall."""
    solution = riemann_problem(REST._replace(velocity=2.0 * speed), REST, GAMMA)
    assert solution.velocity == pytest.approx(speed)
    return solution.pressure, float(solution.state(np.array([speed * (1.0 + 1e-9)]))[0, 0])


def driven(speed: float, cells: int = 400, **parameters: object) -> DetonationTube:
    """Return air after a left piston has moved in or out until the wave is close to the far end."""
    tube = air_tube(cells, left="piston", step_size=0.1 / cells, **parameters)
    advance_tube(tube, 0.3, left_velocity=speed)
    return tube


def close_to_rounding(tube: DetonationTube) -> None:
    """Assert that mass, momentum and energy are balanced."""
    for balance in tube.balances():
        scale = max(abs(float(amount)) for amount in [*balance.stored.values(), *balance.supplied.values(), balance.initial])
        assert abs(float(balance.residual)) <= 1e-12 * scale, balance.quantity


@pytest.mark.parametrize("speed", [0.3, 1.5])
def test_a_piston_drives_the_shock_of_theory(speed: float) -> None:
    tube = driven(speed)
    pressure, density = gas_beside(speed)
    assert tube.get("left_position") == pytest.approx(speed * tube.time)
    assert tube.get("left_piston_pressure") == pytest.approx(pressure, rel=1e-3)
    # Mass balance: the shock's position follows from the compressed gas, which was initially at rest.
    shock = density * speed / (density - 1.0)
    middle = 0.5 * (1.0 + pressure)
    places, pressures = tube.get("cell_position"), tube.get("pressure")
    behind = int(np.flatnonzero(pressures > middle)[-1])
    part = (pressures[behind] - middle) / (pressures[behind] - pressures[behind + 1])
    front = places[behind] + part * (places[behind + 1] - places[behind])
    assert front / tube.time == pytest.approx(shock, rel=5e-3)
    between = (places > speed * tube.time + 0.1 * (front - speed * tube.time)) & (places < front - 0.03)
    np.testing.assert_allclose(pressures[between], pressure, rtol=5e-3)
    np.testing.assert_allclose(tube.get("velocity")[between], speed, rtol=5e-3)
    close_to_rounding(tube)
    energy = tube.balances()[0]
    assert energy.supplied["left_energy"] == pytest.approx(pressure * speed * tube.time, rel=2e-3)


@pytest.mark.parametrize("speed", [-0.4, -2.0])
def test_a_piston_that_is_withdrawn_leaves_the_rarefaction_of_theory(speed: float) -> None:
    tube = driven(speed)
    exact = riemann_problem(REST._replace(velocity=2.0 * speed), REST, GAMMA).state(tube.get("cell_position") / tube.time)
    for name, values in zip(("density", "velocity", "pressure"), exact, strict=True):
        assert np.abs(tube.get(name) - values).mean() < 2e-3 * max(1.0, abs(speed)), name
    assert tube.get("left_piston_pressure") == pytest.approx((1.0 + 0.5 * (GAMMA - 1.0) * speed / SOUND) ** 7, rel=0.02)
    close_to_rounding(tube)


def test_a_piston_that_outruns_the_gas_ends_with_the_cell_that_it_empties() -> None:
    """The piston exceeds the speed of expansion into a vacuum."""
    tube = air_tube(100, left="piston", step_size=2e-4)
    with pytest.raises(ge.StepError, match="(pressure|density): fell to .* in cell 0"):
        advance_tube(tube, 0.1, left_velocity=-1.2 * 2.0 * SOUND / (GAMMA - 1.0))


def test_slow_pistons_compress_without_a_change_of_entropy() -> None:
    tube = air_tube(20, left="piston", right="piston", step_size=5e-3)
    width = 200.0
    tube.step(
        width,
        left_velocity=ge.Profile.half_sine(np.pi / 8.0 / width, width),
        right_velocity=ge.Profile.half_sine(-np.pi / 8.0 / width, width),
    )
    assert tube.get("right_position") - tube.get("left_position") == pytest.approx(0.5, rel=1e-4)
    np.testing.assert_allclose(tube.get("pressure"), 2.0**GAMMA, rtol=2e-3)
    close_to_rounding(tube)


def test_gas_that_moves_with_its_tube_does_not_see_it() -> None:
    """Galilean invariance to rounding, for any density."""
    density = 1.0 + 0.3 * np.sin(np.arange(40.0))
    tube = air_tube(40, left="piston", right="piston", step_size=1e-3)
    tube.reset(velocity=0.7, density=density)
    tube.step(0.5, left_velocity=0.7, right_velocity=0.7)
    np.testing.assert_allclose(tube.get("density"), density, rtol=1e-12)
    np.testing.assert_allclose(tube.get("velocity"), 0.7, rtol=1e-12)
    assert tube.get("left_position") == pytest.approx(0.35)


def smooth_error(cells: int) -> float:
    """Return the mean error of the simple wave of a piston that accelerates from rest."""
    tube = air_tube(cells, left="piston", step_size=0.2 / cells)
    duration, gain = 0.4, -1.0
    ramp = np.linspace(0.0, duration, 2)
    tube.step(duration, left_velocity=ge.Profile.table(ramp, gain * ramp))
    # Each state u left the piston at the time u / a (acceleration a), and runs at c0 + (gamma + 1) / 2 u.
    at = tube.get("cell_position")
    low = np.full_like(at, gain * duration)
    high = np.zeros_like(at)
    for _ in range(60):
        middle = 0.5 * (low + high)
        place = 0.5 * middle**2 / gain + (SOUND + 0.5 * (GAMMA + 1.0) * middle) * (duration - middle / gain)
        low, high = np.where(place < at, middle, low), np.where(place < at, high, middle)
    return float(np.abs(tube.get("velocity") - np.where(at > SOUND * duration, 0.0, low)).mean())


def test_a_wave_of_a_piston_that_gathers_speed_is_of_second_order() -> None:
    errors = [smooth_error(cells) for cells in (50, 100, 200)]
    assert np.log2(errors[0] / errors[-1]) / 2.0 > 1.6


def test_a_piston_behind_a_detonation_and_its_front() -> None:
    """Moving cells preserve the Chapman-Jouguet speed, measured at their positions as the front passes."""
    hot = {"x": [0.0, 0.01], "pressure": 1.2e6, "temperature": 3540.0}
    tube = DetonationTube(length=0.5, cells=250, regions=[hot], right="piston")
    tube.step(1.5e-4, right_velocity=100.0)
    assert tube.get("right_front") < tube.get("right_position")
    assert tube.get("cj_ratio") == pytest.approx(1.0, abs=0.015)
    close_to_rounding(tube)


# Velocities of the left and right pistons, and whether waves become too fast for the cells within 300 ticks of 0.012.
