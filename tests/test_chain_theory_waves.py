"""Stationary waves of the continuum, the chain's solitary wave, and the values derived from both."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from granular_env.components.chain import theory

# -- W(y) -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("c3", [0.002, 0.01, 0.05, 0.1, 4.0 / 27.0, 0.17, 0.18])
def test_extremes_against_the_derivative(c3: float) -> None:
    def slope(y: float) -> float:
        return -(y**0.6) + y + 0.8 * c3 * y**-0.2

    turn = (2.0 / 3.0) ** 2.5
    y1, y2 = theory.extremes(c3)
    assert y1 < turn < y2
    assert y1 == pytest.approx(brentq(slope, 1e-12, turn, xtol=1e-18), rel=1e-10)
    assert y2 == pytest.approx(brentq(slope, turn, 2.0, xtol=1e-18), rel=1e-10)
    step = 1e-6
    assert theory.W(y1 + step, c3) < theory.W(y1, c3) > theory.W(y1 - step, c3)
    assert theory.W(y2 + step, c3) > theory.W(y2, c3) < theory.W(y2 - step, c3)


@pytest.mark.parametrize("ratio", [1.05, 1.2, 1.563, 3.0, 7.93, 20.0, 185.8, 1e3, 1e5])
def test_closed_form_of_the_speed_against_w(ratio: float) -> None:
    """Return the crest from W(y_m) = W(y1) and V/c0 = sqrt(2/3) y1^(-1/5), computed numerically for a given ratio."""
    c3 = theory.c3_from_ratio(ratio)
    y1, y2 = theory.extremes(c3)
    crest = brentq(lambda y: theory.W(y, c3) - theory.W(y1, c3), y2, 2.0, xtol=1e-16)
    assert (crest / y1) ** 0.8 == pytest.approx(ratio, rel=1e-6)
    assert math.sqrt(2.0 / 3.0) * y1**-0.2 == pytest.approx(theory.speed_ratio(ratio), rel=1e-6)
    printed = math.sqrt(4.0 / 15.0 * (3.0 + 2.0 * ratio**2.5 - 5.0 * ratio)) / (ratio - 1.0)
    assert theory.speed_ratio(ratio) == pytest.approx(printed, rel=1e-6)
    assert theory.ratio_from_c3(c3) == pytest.approx(ratio, rel=1e-10)


# -- profiles ---------------------------------------------------------------------------------------------------------

WAVES = {
    "solitary, high": theory.solitary_wave(0.01, samples=2001),
    "solitary": theory.solitary_wave(0.1, samples=2001),
    "solitary, low": theory.solitary_wave(0.185, samples=2001),
}


@pytest.mark.parametrize("name", WAVES)
def test_a_profile_solves_its_equation(name: str) -> None:
    """y_eta^2/2 + W(y) = E, the first integral of (2.6), with y_eta computed from the arrays."""
    wave = WAVES[name]
    slope = CubicSpline(wave.position * math.sqrt(10.0), wave.y)(wave.position * math.sqrt(10.0), 1)
    energy = 0.5 * slope**2 + theory.W(wave.y, wave.c3)
    scale = theory.W(wave.y, wave.c3)
    assert np.abs(energy[5:-5] - wave.energy).max() <= 1e-5 * (wave.energy - scale.min())
    strain = wave.strain
    half = 0.5 * (strain.max() + strain.min())
    crossing = CubicSpline(wave.position, strain - half).roots(extrapolate=False)
    assert crossing[-1] - crossing[0] == pytest.approx(wave.width, rel=1e-6)


def test_the_wave_without_precompression_is_cos4() -> None:
    """(2.7) as the solitary wave at C3 -> 0: xi_m = (5V^2/4c^2)^2, L = 5 pi a/sqrt 10, half width 1.8084 a, zeros."""
    assert theory.PERIOD == pytest.approx(4.967, abs=5e-4) and theory.HALF_WIDTH == pytest.approx(1.8084, abs=5e-5)
    wave, speed = theory.solitary_wave(1e-12), 0.7
    assert wave.width == pytest.approx(theory.HALF_WIDTH, rel=1e-6)
    inside = np.abs(wave.position) < 0.49 * theory.PERIOD
    expected = theory.strain_wave(wave.position[inside], speed)
    assert wave.strain[inside] * speed**4 == pytest.approx(expected, abs=1e-5 * expected.max())
    assert theory.largest_strain(speed) == pytest.approx((1.25 * speed**2) ** 2, rel=1e-14)
    zeros = 5.0 / math.sqrt(10.0) * (0.5 * math.pi + math.pi * np.arange(-2, 2))
    assert theory.strain_wave(zeros, speed) == pytest.approx(np.zeros(4), abs=1e-50)
    assert theory.solitary_strain(np.array([-3.0, 0.0, 3.0]), speed) == pytest.approx(
        [0.0, theory.largest_strain(speed), 0.0], abs=1e-50
    )


def test_waves_tend_to_their_limits() -> None:
    """C3 -> 0: cos^4; r -> 1: the soliton."""
    assert theory.solitary_wave(theory.c3_from_ratio(1e8)).width == pytest.approx(theory.HALF_WIDTH, rel=1e-6)
    wave = theory.solitary_wave(theory.c3_from_ratio(1.001))
    shape = (wave.strain_ratio - 1.0) / 0.001
    assert shape == pytest.approx(theory.korteweg_de_vries_shape(wave.position, 0.001), abs=5e-4)


@pytest.mark.parametrize(("rise", "error"), [(0.01, 1.04e-6), (0.1, 9.95e-5), (1.0, 7.08e-3)])
def test_the_speed_of_the_soliton(rise: float, error: float) -> None:
    """sqrt(1 + e/6) deviates from the closed form by about e^2/100."""
    exact = theory.speed_ratio(1.0 + rise)
    assert theory.korteweg_de_vries_speed_ratio(rise) / exact - 1.0 == pytest.approx(error, rel=5e-3)


# -- shocks -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1.01, 2.0, 30.0])
def test_shocks_keep_mass_and_momentum(ratio: float) -> None:
    expected = math.sqrt(2.0 / 3.0 * (ratio**1.5 - 1.0) / (ratio - 1.0))
    assert theory.shock_speed_ratio(ratio) == pytest.approx(expected, rel=1e-12)


def test_the_paper_s_overshoots() -> None:
    """xi_m/xi_c = (5/4)^2 and p_m/p_c = (5/4)^3 (the paper's 1.56 and 1.95) are the limits of vanishing precompression."""
    assert theory.largest_strain(0.3) / theory.shock_strain(0.3) == pytest.approx(theory.STRAIN_OVERSHOOT, rel=1e-12)
    assert theory.STRAIN_OVERSHOOT == pytest.approx(1.56, abs=5e-3) and theory.PRESSURE_OVERSHOOT == pytest.approx(
        1.95, abs=5e-3
    )
    assert theory.PRESSURE_OVERSHOOT == pytest.approx(1.25**3) == pytest.approx(theory.STRAIN_OVERSHOOT**1.5)
    c3 = 1e-6
    assert theory.solitary_wave(c3).amplitude_ratio / theory.shock_ratio(c3) == pytest.approx(1.5625, rel=3e-3)


# -- the chain's wave -------------------------------------------------------------------------------------------------


def test_the_uncompressed_wave_of_the_lattice() -> None:
    wave = theory.lattice_wave(0.0)
    top = wave.velocity.max()
    assert wave.speed_coefficient == pytest.approx(theory.SOLITARY_SPEED, rel=1e-9) == pytest.approx(0.907470, abs=5e-7)
    energy = wave.kinetic_energy + wave.potential_energy
    assert energy / top**2 == pytest.approx(theory.SOLITARY_ENERGY, rel=1e-9) == pytest.approx(1.06932, abs=5e-6)
    assert wave.momentum / top == pytest.approx(theory.SOLITARY_MOMENTUM, rel=1e-9) == pytest.approx(1.66997, abs=5e-6)
    assert wave.width == pytest.approx(1.7257, abs=5e-5)
    assert wave.kinetic_energy / wave.potential_energy == pytest.approx(1.25, rel=1e-10)
    overshoot = wave.overlap.max() / wave.speed**4
    assert overshoot == pytest.approx(theory.LATTICE_STRAIN_OVERSHOOT, rel=1e-9)
    assert overshoot**1.5 == pytest.approx(theory.LATTICE_PRESSURE_OVERSHOOT, rel=1e-9)
    # The total displacement D is the sum of all overlaps, and the momentum is P = m V D.
    assert wave.displacement[0] == pytest.approx(wave.momentum / wave.speed, rel=1e-6)


@pytest.mark.parametrize(("rest", "height"), [(0.0, 1.0), (0.0, 1e-4), (1.0, 0.005), (1.0, 0.1), (0.2, 1.0), (1e-3, 1.0)])
def test_the_lattice_wave_solves_newton_s_equations(rest: float, height: float) -> None:
    """V^2 u'' is the difference of the contact forces half a grain to both sides, for any amplitude."""
    wave = theory.lattice_wave(rest, height)
    force = (rest + wave.overlap) ** 1.5 - rest**1.5
    half = round(0.5 / (wave.position[1] - wave.position[0]))
    push = np.roll(force, -half) - np.roll(force, half)
    acceleration = wave.speed * CubicSpline(wave.position, wave.velocity)(wave.position, 1)
    assert np.abs(acceleration - push).max() <= 2e-5 * np.abs(push).max()
    overlap = np.roll(wave.displacement, half) - np.roll(wave.displacement, -half)
    assert np.abs(overlap - wave.overlap)[50:-50].max() <= 1e-9 * height


@pytest.mark.parametrize(
    ("ratio", "error"), [(185.8, -1.176), (30.0, -0.983), (7.93, -0.597), (1.563, -0.0405), (1.1, -0.0019)]
)
def test_the_continuum_against_the_lattice(ratio: float, error: float) -> None:
    """Deficit of the continuum's wave speed relative to the chain's [%]; without precompression 0.79 % faster, in v_m^(1/5)."""
    wave = theory.lattice_wave(1.0, ratio - 1.0)
    assert 100.0 * (theory.speed_ratio(ratio) / wave.speed_ratio - 1.0) == pytest.approx(error, abs=6e-4)


def test_coefficients_of_the_continuum_and_of_the_lattice() -> None:
    """The paper's 0.915 is the continuum's (16/25)^(1/5) with v_m1/v0 = 1.56; with 0.907470 the ratio is 1.625."""
    assert theory.CONTINUUM_SOLITARY_SPEED == pytest.approx(0.915, abs=5e-4)
    assert theory.front_velocity_ratio(0.915) == pytest.approx(1.56, abs=1e-3)
    assert theory.front_velocity_ratio(theory.CONTINUUM_SOLITARY_SPEED) == pytest.approx(theory.STRAIN_OVERSHOOT, rel=1e-12)
    assert theory.front_velocity_ratio(theory.SOLITARY_SPEED) == pytest.approx(1.625, abs=5e-4)
