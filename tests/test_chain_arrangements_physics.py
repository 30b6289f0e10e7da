"""Known physics of dimers, tapered and decorated chains and impurities, in chains arranged by name."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import fft

import granular_env as ge
from granular_env.components.chain import theory
from granular_env.components.support.counter_random import uniform
from granular_env.domains.chain import measurement

R = 3e-3
FORCE = 20.0
STEEL = {"density": 7800.0, "young": 2e11, "poisson": 0.29}


def spectrum(chain: ge.Chain, samples: int, every: int, grains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angular frequencies, shape (f,) [rad/s], and the power of each grain's velocity, shape (f, grains)."""
    velocity = np.empty((samples, len(grains)))
    for row in velocity:
        chain.step(every * chain.step_size)
        row[:] = chain.get("velocity")[grains]
    power = np.abs(fft.rfft(velocity * np.hanning(samples)[:, None], axis=0)) ** 2
    return 2.0 * np.pi * fft.rfftfreq(samples, every * chain.step_size), power


@pytest.fixture(scope="module")
def shaken_dimer():
    """Return band edges, frequencies and power of a steel-aluminium dimer under 20 N with random velocities."""
    chain = ge.make(
        "chain", grains=301, precompression=FORCE, step_size=5e-7,
        arrangement={"name": "dimer", "radius": R, "material": ["steel", "aluminium"]},
    )  # fmt: skip
    tangent = theory.tangent_stiffness(chain.geometry.stiffness[1], FORCE)
    edges = theory.diatomic_band_edges(tangent, chain.geometry.mass[1], chain.geometry.mass[0])
    # Amplitude of 1e-4 of the static overlap; nonlinear frequency shifts are of the order of its square.
    chain.reset(velocity=1e-4 * edges.acoustic * chain.geometry.rest_overlap[1] * (uniform(1, 0, 301) - 0.5))
    omega, power = spectrum(chain, 1 << 15, 8, np.arange(0, 301, 10))
    return edges, omega, power.sum(axis=1)


def test_band_edges_of_a_pressed_dimer(shaken_dimer):
    """sqrt(2K/m1), sqrt(2K/m2) and sqrt(2K(1/m1 + 1/m2)) are the band edges.

    The tolerance 3e-3 covers the distance of an edge to the nearest mode of 150 cells, and the line width.
    """
    edges, omega, power = shaken_dimer
    assert omega[1] < 4e-4 * edges.acoustic
    sounding = omega[power > 1e-4 * power.max()]
    middle = 0.5 * (edges.acoustic + edges.optical_low)
    measured = sounding[sounding < middle].max(), sounding[sounding > middle].min(), sounding.max()
    np.testing.assert_allclose(measured, edges, rtol=3e-3)


@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.8])
def test_a_light_impurity_holds_a_mode_above_the_band(ratio):
    """Linear chain with one mass mu m: Omega = 2 sqrt(K/m) / sqrt(mu (2 - mu)), amplitude ratio mu/(2 - mu) per grain.

    Maradudin, Montroll, Weiss, Ipatova, Theory of Lattice Dynamics in the Harmonic Approximation (1971).
    """
    mass = ge.make("chain", grains=2, radius=R).geometry.mass[0]
    chain = ge.make(
        "chain", grains=101, radius=R, precompression=FORCE, step_size=2e-7,
        arrangement={"name": "impurity", "index": 50, "mass": ratio * mass},
    )  # fmt: skip
    top = theory.monatomic_cutoff_frequency(theory.tangent_stiffness(chain.geometry.stiffness[1], FORCE), mass)
    chain.reset(velocity={50: 1e-4 * top * chain.geometry.rest_overlap[1]})
    omega, power = spectrum(chain, 1 << 14, 10, np.arange(50, 54))
    line = np.argmax(np.where(omega > 1.002 * top, power[:, 0], 0.0))
    below, at, above = np.log(power[line - 1 : line + 2, 0])
    frequency = omega[line] + omega[1] * 0.5 * (below - above) / (below - 2.0 * at + above)
    assert frequency == pytest.approx(top / math.sqrt(ratio * (2.0 - ratio)), rel=5e-5)
    amplitude = np.sqrt(power[line] / power[line, 0])
    np.testing.assert_allclose(amplitude, (ratio / (2.0 - ratio)) ** np.arange(4), rtol=1e-3)


@pytest.mark.parametrize("taper", [0.1, 0.05, 0.02, -0.05])
def test_a_tapered_chain_with_gaps_is_a_row_of_collisions(taper):
    """V_(i+1)/v_i = 2/(1 + (1-q)^3) is exact for pairwise collisions, to the accuracy of the integrator."""
    chain = ge.make(
        "chain", grains=12, gap=1e-3, step_size=2e-8,
        arrangement={"name": "tapered", "first_radius": R, "taper": taper},
    )  # fmt: skip
    chain.reset(velocity={0: 1.0})
    history = measurement.observe(chain, duration=2.5e-2, every=5e-5)
    np.testing.assert_allclose(history.velocity.max(axis=0), theory.tapered_velocities(taper, 12), rtol=1e-6)


def passed_on(ratio: float) -> float:
    """Return the fraction of a pulse's force left between contacts 60 and 120 of a touching dimer of equal radii."""
    light = ge.Material(**{**STEEL, "density": ratio * STEEL["density"]})
    arrangement = {"name": "dimer", "material": [ge.Material(**STEEL), light]}
    chain = ge.make("chain", grains=161, radius=R, arrangement=arrangement)
    chain.reset(velocity={0: 1.0})
    force = measurement.observe(chain, duration=1.4e-3, every=1e-6).contact_force.max(axis=0)
    return float(force[120] / force[60])


def test_dimers_pass_a_pulse_on_at_some_mass_ratios_and_scatter_it_at_others():
    """Solitary waves exist at mass ratios 0.3428, 0.1548 (and 1), with strong attenuation between, near 0.59 and 0.24.

    K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E 83, 036606 (2011); J. Nonlinear Sci. 23, 363 (2013).
    """
    for solitary in (0.3428, 0.1548):
        assert passed_on(solitary) == pytest.approx(1.0, abs=2e-3)
    for lossy, kept in ((0.59, 0.6), (0.24, 0.95)):
        assert passed_on(lossy) < kept
        assert passed_on(0.8 * lossy) > passed_on(lossy) < passed_on(1.25 * lossy)


def thrown_off(**parameters: object) -> float:
    """Return the fraction of the striker's energy in the departing last grain."""
    chain = ge.make("chain", **parameters)
    chain.reset(velocity={0: 1.0})
    fastest = measurement.observe(chain, duration=1e-3, every=2e-7).velocity[:, -1].max()
    return float(0.5 * chain.geometry.mass[-1] * fastest**2 / (0.5 * chain.geometry.mass[0]))


def test_decoration_and_taper_together_absorb_a_blow():
    """Doney & Sen (2006): for 21 large grains, both together transmit less (0.59) than taper (0.74) or decoration (0.96).

    The small grains make the chain longer; a taper over the same number of grains transmits less (0.57).
    """
    decorated = {"name": "decorated", "radius": R, "decoration_radius": 1e-3}
    tapered = {"name": "tapered", "first_radius": R, "taper": 0.05}
    alone = thrown_off(grains=21, radius=R), thrown_off(grains=41, arrangement=decorated)
    both = thrown_off(grains=41, arrangement={**decorated, "taper": 0.05})
    assert both < thrown_off(grains=21, arrangement=tapered) < min(alone)
    assert thrown_off(grains=41, arrangement=tapered) == pytest.approx(0.574, abs=5e-4)
