"""Exact solutions for the gas against published numbers and against their equations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granular_env.components.detonation.gases import Gas, fit_gas, gas_from_name
from granular_env.components.detonation.theory import (
    Detonation,
    Flow,
    ReactionZone,
    TaylorWave,
    chapman_jouguet,
    reflected_pressure,
    riemann_problem,
    state_behind_shock,
)  # fmt: skip

TEMPERATURE = 295.0


def mixture(pressure: float) -> tuple[Gas, Flow, Detonation]:
    """Return C2H4 + 3 O2 at an initial pressure, at rest, and its detonation."""
    gas = gas_from_name("ethylene_oxygen", pressure, TEMPERATURE)
    ahead = Flow(pressure / (gas.gas_constant * TEMPERATURE), 0.0, pressure)
    return gas, ahead, chapman_jouguet(gas, pressure, ahead.density)


def fluxes(state: Flow, gas: Gas, speed: float, burnt: bool) -> np.ndarray:
    """Return the fluxes of mass, momentum and energy through a front that moves at `speed`."""
    w = state.velocity - speed
    enthalpy = gas.gamma / (gas.gamma - 1.0) * state.pressure / state.density + (0.0 if burnt else gas.heat_release)
    return np.array([state.density * w, state.density * w * w + state.pressure, state.density * w * (enthalpy + 0.5 * w * w)])


# Chemical equilibrium by Cantera with gri30.
@pytest.mark.parametrize(
    ("pressure", "density", "speed", "cj_pressure", "gamma", "heat", "plateau"),
    [
        (80e3, 1.0115, 2363.2, 2.680e6, 1.1374, 9.208e6, 0.368),
        (100e3, 1.2644, 2373.9, 3.378e6, 1.1387, 9.197e6, 0.368),
    ],
)
def test_the_mixture_has_the_detonation_of_equilibrium(
    pressure: float, density: float, speed: float, cj_pressure: float, gamma: float, heat: float, plateau: float
) -> None:
    gas, ahead, front = mixture(pressure)
    assert ahead.density == pytest.approx(density, rel=1e-4)
    assert (front.speed, front.burnt.pressure) == pytest.approx((speed, cj_pressure), rel=3e-4)
    assert (gas.gamma, gas.heat_release) == pytest.approx((gamma, heat), rel=1e-4)
    assert TaylorWave(front, ahead, gas.gamma).plateau / front.burnt.pressure == pytest.approx(plateau, abs=5e-4)


def test_a_gas_is_fitted_to_a_speed_and_a_pressure() -> None:
    fitted = fit_gas(2373.9, 3.378e6, 100e3, 1.2644, TEMPERATURE)
    front = chapman_jouguet(fitted, 100e3, 1.2644)
    assert (front.speed, front.burnt.pressure) == pytest.approx((2373.9, 3.378e6), rel=1e-12)
    assert fitted.gas_constant * TEMPERATURE == pytest.approx(100e3 / 1.2644, rel=1e-14)


def test_a_detonation_conserves_and_is_sonic_behind() -> None:
    gas, ahead, front = mixture(90e3)
    before = fluxes(ahead, gas, front.speed, burnt=False)
    np.testing.assert_allclose(fluxes(front.burnt, gas, front.speed, burnt=True), before, rtol=1e-12)
    np.testing.assert_allclose(fluxes(front.shocked, gas, front.speed, burnt=False), before, rtol=1e-12)
    assert front.burnt.velocity + front.sound_speed == pytest.approx(front.speed, rel=1e-12)
    assert front.shocked == pytest.approx(state_behind_shock(ahead, gas.gamma, front.mach), rel=1e-12)


def test_without_heat_the_detonation_is_a_sound_wave() -> None:
    front = chapman_jouguet(Gas(), 1e5, 1.2)
    assert front.mach == 1.0
    assert front.burnt == front.shocked == Flow(1.2, 0.0, 1e5)


def test_between_pressures_the_mixture_is_interpolated() -> None:
    low, middle, high = (gas_from_name("ethylene_oxygen", pressure, TEMPERATURE) for pressure in (100e3, 110e3, 120e3))
    assert middle.gamma == pytest.approx(0.5 * (low.gamma + high.gamma), rel=1e-14)
    # Equilibrium at 110 kPa by interpolation: the speed is nearly linear in the logarithm of the pressure.
    assert mixture(110e3)[2].speed == pytest.approx(2373.94 + 8.78 * math.log(1.1) / math.log(1.2), abs=0.2)


# E. F. Toro (2009), table 4.3: pressure and velocity between the waves, tests 1 to 5.
@pytest.mark.parametrize(
    ("left", "right", "pressure", "velocity"),
    [
        (Flow(1.0, 0.0, 1.0), Flow(0.125, 0.0, 0.1), 0.30313, 0.92745),
        (Flow(1.0, -2.0, 0.4), Flow(1.0, 2.0, 0.4), 0.00189, 0.0),
        (Flow(1.0, 0.0, 1000.0), Flow(1.0, 0.0, 0.01), 460.894, 19.5975),
        (Flow(1.0, 0.0, 0.01), Flow(1.0, 0.0, 100.0), 46.0950, -6.19633),
        (Flow(5.99924, 19.5975, 460.894), Flow(5.99242, -6.19633, 46.0950), 1691.64, 8.68975),
    ],
)
def test_riemann_problems_of_the_textbook(left: Flow, right: Flow, pressure: float, velocity: float) -> None:
    solution = riemann_problem(left, right, 1.4)
    assert solution.pressure == pytest.approx(pressure, rel=2e-5, abs=5e-6)
    assert solution.velocity == pytest.approx(velocity, rel=2e-5, abs=1e-8)


def test_a_riemann_solution_conserves() -> None:
    """The content of the gas between x = -1 and 1 changes by the fluxes at both ends."""
    left, right, gas = Flow(1.0, 0.0, 1.0), Flow(0.125, 0.0, 0.1), Gas()
    solution = riemann_problem(left, right, gas.gamma)
    # Midpoint rule on fine cells, first-order at the two jumps.
    x = np.linspace(-1.0, 1.0, 400_001)[:-1] + 2.5e-6
    density, velocity, pressure = solution.state(x / 0.3)
    stored = [density.mean() * 2.0, (density * velocity).mean() * 2.0]
    stored.append((pressure / 0.4 + 0.5 * density * velocity**2).mean() * 2.0)
    initial = np.array([left.density + right.density, 0.0, (left.pressure + right.pressure) / 0.4])
    gained = 0.3 * (fluxes(left, gas, 0.0, burnt=True) - fluxes(right, gas, 0.0, burnt=True))
    np.testing.assert_allclose(stored, initial + gained, atol=1e-5)


def test_a_wall_stops_gas_as_a_shock_does() -> None:
    """The reflected pressure is that behind the shock that stops the incoming gas; for a detonation about 2.5 P_CJ."""
    gas, _, front = mixture(100e3)
    coming = front.burnt
    wall = riemann_problem(coming, coming._replace(velocity=-coming.velocity), gas.gamma)
    assert reflected_pressure(coming, gas.gamma) == pytest.approx(wall.pressure, rel=1e-12)
    assert wall.pressure / coming.pressure == pytest.approx(2.5, rel=0.01)


def test_the_wall_pressure_of_a_strong_detonation_depends_on_gamma_alone() -> None:
    """The ratio to the Chapman-Jouguet pressure is (5 g + 1 + sqrt(17 g^2 + 2 g + 1)) / (4 g)."""
    g = 1.3
    coming = chapman_jouguet(Gas(gamma=g, heat_release=1e14), 1e5, 1.2).burnt
    strong = (5 * g + 1 + math.sqrt(17 * g * g + 2 * g + 1)) / (4 * g)
    assert reflected_pressure(coming, g) / coming.pressure == pytest.approx(strong, rel=1e-7)


def test_the_taylor_wave_solves_the_equations_of_motion() -> None:
    """Central differences along x and t satisfy the equations up to second order in their width."""
    gas, ahead, front = mixture(100e3)
    wave = TaylorWave(front, ahead, gas.gamma)
    x, t = np.linspace(0.55, 0.95, 9) * front.speed * 1e-4, 1e-4
    dx, dt = 1e-5, 1e-9
    (_, u, p), (rho, _, _) = wave.state(x, t), wave.state(x, t)
    along = [(high - low) / (2 * dx) for high, low in zip(wave.state(x + dx, t), wave.state(x - dx, t), strict=True)]
    onward = [(high - low) / (2 * dt) for high, low in zip(wave.state(x, t + dt), wave.state(x, t - dt), strict=True)]
    scale = np.abs(along[2]).max() / rho
    np.testing.assert_allclose(onward[0] + u * along[0] + rho * along[1], 0.0, atol=1e-5 * np.abs(onward[0]).max())
    np.testing.assert_allclose(onward[1] + u * along[1] + along[2] / rho, 0.0, atol=1e-5 * scale.max())
    np.testing.assert_allclose(p / rho**gas.gamma, p[0] / rho[0] ** gas.gamma, rtol=1e-12)


def test_the_taylor_wave_begins_at_the_front_and_ends_at_rest() -> None:
    gas, ahead, front = mixture(100e3)
    wave = TaylorWave(front, ahead, gas.gamma)
    rest = wave.resting_sound_speed
    states = wave.state(np.array([0.5 * rest, rest, front.speed, 1.01 * front.speed]) * 1e-4, 1e-4)
    np.testing.assert_allclose(states[:, 2], front.burnt, rtol=1e-12)
    np.testing.assert_allclose(states[:, 3], ahead)
    np.testing.assert_allclose(states[1:, 0], [0.0, wave.plateau], rtol=1e-12)
    np.testing.assert_allclose(states[:, 1], states[:, 0], rtol=1e-12, atol=1e-9)


def test_the_pressure_decays_in_a_third_of_the_time_since_ignition() -> None:
    """Rule of thumb: T = x / 3 D within 5 % at every position."""
    gas, ahead, front = mixture(100e3)
    wave = TaylorWave(front, ahead, gas.gamma)
    for x in (0.5, 1.5):
        assert wave.decay_time(x) == pytest.approx(x / (3.0 * front.speed), rel=0.05)


def test_the_reaction_zone_conserves_and_ends_at_the_sonic_point() -> None:
    gas, ahead, front = mixture(100e3)
    zone = ReactionZone(gas, ahead, 2e5, 1e6)
    before = fluxes(ahead, gas, front.speed, burnt=False)
    for progress in (0.0, 0.3, 0.8, 1.0):
        state = Flow(*zone.state(np.array(progress)))
        remaining = gas.model_copy(update={"heat_release": (1.0 - progress) * gas.heat_release})
        np.testing.assert_allclose(fluxes(state, remaining, front.speed, burnt=False), before, rtol=1e-12)
    np.testing.assert_allclose(zone.state(np.array(0.0)), front.shocked, rtol=1e-12)
    np.testing.assert_allclose(zone.state(np.array(1.0)), front.burnt, rtol=1e-12)


def test_the_length_of_the_reaction_zone_solves_its_equation() -> None:
    gas, ahead, front = mixture(100e3)
    energy = 2.5 * front.shocked.pressure / front.shocked.density
    zone = ReactionZone(gas, ahead, 2e5, energy)
    progress = np.array([0.3, 0.3001])
    lengths = zone.distance(progress)
    density, velocity, pressure = zone.state(progress).mean(axis=1)
    rate = zone.rate * (1.0 - progress.mean()) * math.exp(-energy * density / pressure)
    assert np.diff(lengths)[0] / np.diff(progress)[0] == pytest.approx((front.speed - velocity) / rate, rel=1e-5)
    # Lengths scale as 1 / k.
    assert ReactionZone(gas, ahead, 4e5, energy).half_reaction_length == pytest.approx(
        0.5 * zone.half_reaction_length, rel=1e-13
    )
