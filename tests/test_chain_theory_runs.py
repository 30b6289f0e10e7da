"""Runs of the chain against theory: solitary waves under precompression, small oscillations, tapers, energy partition."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.chain_tools import peaks, unit_chain

import granular_env as ge
from granular_env.components.chain import theory

# -- solitary waves on a precompressed chain --------------------------------------------------------------------------


def travelled(ratio: float, start: dict[str, np.ndarray], first: int, last: int, grains: int) -> tuple[float, float]:
    """Return peak strain over rest strain at contact `last`, and V/c0 between both contacts (crest overlap about 1)."""
    rest = 1.0 / ratio
    chain = unit_chain(grains, precompression=rest**1.5, step_size=0.01)
    chain.reset(**start)
    sound = theory.sound_speed(1.0, 1.0, rest)
    width = 8.0 + 4.0 / math.sqrt(ratio - 1.0)
    overlap = []
    for _ in range(int((last + 2.0 * width) / (sound * 0.25))):
        chain.step(0.25)
        overlap.append(chain.get("overlap")[[first, last]] - rest)
        if overlap[-1][1] < 0.2 * overlap[-1][0] < 0.0:
            break
    seen = np.array(overlap)
    (begin, _), (end, height) = (
        max(peaks(seen[:, column], 0.3 * seen[:, column].max()), key=lambda peak: peak[1]) for column in range(2)
    )
    return 1.0 + height / rest, (last - first) / ((end - begin) * 0.25) / sound


def lattice_start(ratio: float, grains: int, middle: int) -> dict[str, np.ndarray]:
    """Return displacements and velocities of the lattice's solitary wave with its crest at a grain."""
    rest = 1.0 / ratio
    wave = theory.lattice_wave(rest, 1.0 - rest)
    place = np.arange(grains) - float(middle)
    velocity = np.interp(place, wave.position, wave.velocity, left=0.0, right=0.0)
    return {"displacement": np.interp(place, wave.position, wave.displacement), "velocity": velocity}


@pytest.mark.parametrize(("ratio", "error"), [(185.8, -1.18), (30.0, -0.98), (7.930, -0.60), (3.0, -0.22), (1.563, -0.04)])
def test_solitary_wave_under_precompression(ratio: float, error: float) -> None:
    """After 180 grains the wave keeps its height and the speed of `lattice_wave`; the speed of (2.4) differs by `error` %."""
    seen, speed = travelled(ratio, lattice_start(ratio, 260, 40), 80, 220, 260)
    assert seen == pytest.approx(ratio, rel=1e-6)
    assert speed == pytest.approx(theory.lattice_wave(1.0, ratio - 1.0).speed_ratio, rel=2e-7)
    assert 100.0 * (theory.speed_ratio(seen) / speed - 1.0) == pytest.approx(error, abs=5e-3)


@pytest.mark.parametrize(("rise", "grains", "bound"), [(0.1, 800, 3e-4), (0.01, 1600, 1.3e-5)])
def test_a_soliton_of_the_weakly_nonlinear_limit_travels(rise: float, grains: int, bound: float) -> None:
    """A wave started as sech^2 is nearly exact: it keeps its height, and the speed sqrt(1 + e/6) within `bound`."""
    rest, begin = 1.0 / (1.0 + rise), 20.0 / math.sqrt(rise) + 20.0
    place = np.arange(grains) - begin
    rate, height = math.sqrt(0.5 * rise), rise * rest
    sound = theory.sound_speed(1.0, 1.0, rest)
    speed = sound * theory.korteweg_de_vries_speed_ratio(rise)
    start = {
        "displacement": height / rate * (1.0 - np.tanh(rate * place)),
        "velocity": speed * height * theory.korteweg_de_vries_shape(place, rise),
    }
    seen, ratio = travelled(1.0 + rise, start, int(0.4 * grains), int(grains - begin - 10.0), grains)
    assert seen - 1.0 == pytest.approx(rise, rel=0.02)
    assert abs(theory.korteweg_de_vries_speed_ratio(rise) / ratio - 1.0) <= bound
    # The sound speed alone would be wrong by e/12.
    assert ratio - 1.0 > 50.0 * bound * rise


def uncompressed_wave(grains: int, middle: int, step_size: float) -> ge.Chain:
    """Return a touching chain that contains only the lattice's solitary wave, v_m = 1."""
    wave = theory.lattice_wave(0.0, theory.LATTICE_STRAIN_OVERSHOOT * theory.SOLITARY_SPEED**4)
    assert wave.velocity.max() == pytest.approx(1.0, rel=1e-9)
    chain = unit_chain(grains, step_size=step_size)
    place = np.arange(grains) - float(middle)
    chain.reset(
        displacement=np.interp(place, wave.position, wave.displacement),
        velocity=np.interp(place, wave.position, wave.velocity, left=0.0, right=0.0),
    )
    return chain


def test_shares_of_energy_of_a_travelling_wave() -> None:
    """The mean of Ek/Ep of a single wave is 1.25077; the ratio of the means is 5/4."""
    wave = theory.lattice_wave(0.0)
    chain = uncompressed_wave(80, 30, 0.01)
    kinetic, potential = [], []
    for _ in range(round(10.0 / theory.SOLITARY_SPEED / 0.01)):
        chain.step()
        balances = chain.balance_values()
        kinetic.append(balances["kinetic_energy"])
        potential.append(balances["potential_energy"])
    assert np.mean(np.divide(kinetic, potential)) == pytest.approx(wave.energy_ratio, abs=2e-5)
    assert wave.energy_ratio == pytest.approx(1.25077, abs=1e-5)
    assert np.mean(kinetic) / np.mean(potential) == pytest.approx(1.25, abs=2e-5)
    assert np.mean(kinetic) + np.mean(potential) == pytest.approx(theory.SOLITARY_ENERGY, rel=2e-5)
    assert chain.get("momentum") == pytest.approx(theory.SOLITARY_MOMENTUM, rel=1e-9)


def test_a_free_end_leaves() -> None:
    """A free end grain leaves at 1.44606 v_m after a solitary wave arrives."""
    chain = uncompressed_wave(60, 30, 0.01)
    chain.step(80.0)
    assert chain.get("velocity")[-1] == pytest.approx(theory.FREE_END_VELOCITY, abs=1e-5)


# -- small oscillations -----------------------------------------------------------------------------------------------

GRAINS = 23
# The step is so small that PEFRL's error is below 1e-8, and the amplitude so small that overlaps of 4 behave linearly.
STEP, TINY = 0.01, 1e-6


def frequency_of_mode(shape: np.ndarray, expected: float, **parameters: object) -> float:
    """Return the frequency of a tiny standing wave between two fixed grains, from its phase after 10.25 periods [rad/s]."""
    time = round(10.25 * 2.0 * math.pi / expected / STEP) * STEP
    chain = unit_chain(GRAINS, precompression=8.0, left="fixed_grain", right="fixed_grain", step_size=STEP, **parameters)
    chain.reset(displacement=TINY * shape)
    chain.step(time)
    seen, mass = chain.get("displacement"), chain.geometry.mass
    part = float((mass * shape * seen).sum() / (mass * shape**2).sum()) / TINY
    assert np.abs(seen - TINY * part * shape).max() <= 1e-5 * TINY  # the mode is unchanged
    whole = round(expected * time / math.pi - 0.5)
    return (math.pi * whole + math.acos(part if whole % 2 == 0 else -part)) / time


@pytest.mark.parametrize("mode", [1, 6, 12, 18, 23])
def test_frequencies_of_equal_grains(mode: int) -> None:
    """omega = 2 sqrt(K/m) sin(kappa a/2), up to the edge of the band."""
    tangent = theory.tangent_stiffness(1.0, 8.0)
    phase = math.pi * mode / (GRAINS + 1)
    expected = theory.monatomic_frequency(phase, tangent, 1.0, 1.0)
    shape = np.sin(phase * np.arange(1, GRAINS + 1))
    assert frequency_of_mode(shape, expected) == pytest.approx(expected, rel=1e-7)
    assert expected <= theory.monatomic_cutoff_frequency(tangent, 1.0) == pytest.approx(2.0 * math.sqrt(3.0), rel=1e-12)


def diatomic_shape(phase: float, frequency: float, tangent: float, light: float) -> np.ndarray:
    """With light grains at odd places, (2K - m omega^2) u_light = 2K cos(kappa a) u_heavy."""
    place = np.arange(1, GRAINS + 1)
    part = 2.0 * tangent - light * frequency**2
    sizes = (2.0 * tangent * math.cos(phase), part) if abs(part) > 1e-6 else (1.0, 0.0)
    return np.where(place % 2 == 1, *sizes) * np.sin(phase * place)


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("mode", [1, 4, 8, 11])
def test_frequencies_of_two_masses(mode: int, branch: int) -> None:
    light, heavy, tangent = 1.0, 3.0, theory.tangent_stiffness(1.0, 8.0)
    phase = math.pi * mode / (GRAINS + 1)
    expected = theory.diatomic_frequencies(phase, tangent, light, heavy, 2.0)[branch]
    shape = diatomic_shape(phase, expected, tangent, light)
    masses = np.where(np.arange(GRAINS) % 2 == 0, light, heavy).tolist()
    assert frequency_of_mode(shape / np.abs(shape).max(), expected, mass=masses) == pytest.approx(expected, rel=1e-7)


# -- tapers -----------------------------------------------------------------------------------------------------------


def tapered(taper: float, lead: int, grains: int, **parameters: object) -> np.ndarray:
    """Return the largest velocity of each tapered grain, after `lead` equal grains, shape (grains,)."""
    radius = 0.01 * np.concatenate((np.ones(lead), (1.0 - taper) ** np.arange(1.0, grains + 1.0)))
    chain = ge.make("chain", grains=lead + grains, radius=radius.tolist(), step_size=2e-8, **parameters)
    chain.reset(velocity={0: 0.01})
    top = np.zeros(lead + grains)
    while chain.time < 0.1:
        chain.step(2e-7)
        top = np.maximum(top, chain.get("velocity"))
        if chain.get("velocity")[-2] < 0.9 * top[-2] and top[-2] > 0.3 * top[-3]:
            return top[lead:]
    raise AssertionError("the pulse did not arrive")


@pytest.mark.parametrize(("taper", "error"), [(0.02, -0.03), (0.05, -0.35), (0.1, -2.5), (-0.02, -0.01), (-0.05, -0.05)])
def test_touching_tapered_chain(taper: float, error: float) -> None:
    """Settled ratio of successive peaks against 2/(1 + (1 - q)^3) [%]; the binary collision law is the limit of small q."""
    top = tapered(taper, 20, 25)
    seen = (top[20] / top[14]) ** (1.0 / 6.0)
    assert 100.0 * (seen / theory.tapered_ratio(taper) - 1.0) == pytest.approx(error, abs=max(0.012, 0.04 * abs(error)))


@pytest.mark.parametrize("taper", [0.05, 0.3])
def test_gapped_tapered_chain(taper: float) -> None:
    """With gaps wider than an overlap, collisions are isolated and the law is exact."""
    top = tapered(taper, 1, 10, gap=1e-5)
    assert top[1:-1] / top[:-2] == pytest.approx(np.full(8, theory.tapered_ratio(taper)), rel=1e-6)
