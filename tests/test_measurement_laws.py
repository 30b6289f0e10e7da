"""Histories of chains with other contact laws: forces and energies equal the chain's values, or are refused."""

from __future__ import annotations

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.errors import LogError
from granular_env.domains.chain import measurement

pytestmark = pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")

PLASTIC = {"name": "elastic_plastic", "yield_pressure": 3.2e9}
LAWS = {
    "hertz": {},
    "power": {"law": {"name": "power", "exponent": 2.0}, "contact_stiffness": 1e12},
    "viscous": {"law": {"name": "viscous", "dissipation": 20.0}},
    "kuwabara_kono": {"law": {"name": "kuwabara_kono", "dissipation": 4e3}},
    "elastic_plastic": {"law": PLASTIC},
}
KEPT = ["velocity", "displacement", "contact_force", "potential_energy"]


def recorded(path, name, variables=KEPT, **parameters):
    """Return the log of a short run of a precompressed chain between walls in which one grain starts with a velocity."""
    chain = ge.make("chain", grains=8, precompression=20.0, left="plane", right="plane", **{**LAWS[name], **parameters})
    with ge.record(chain, path, every=1e-6, variables=variables):
        chain.reset(velocity={3: 1.0})
        chain.step(4e-5)
    return ge.open_log(path)


@pytest.mark.parametrize("name", [name for name in LAWS if name != "elastic_plastic"])
def test_forces_have_the_bits_of_the_chain_and_energies_its_sum(tmp_path, name):
    with recorded(tmp_path / "log.mcap", name) as log:
        force, energy = log.series("contact_force")[1], log.series("potential_energy")[1]
        frames = measurement.history(log)
    by_law = measurement.History(
        frames.time, frames.velocity, frames.mass, frames.stiffness, frames.rest_overlap, frames.position,
        frames.displacement, law=frames.law, law_constants=frames.law_constants,
    )  # fmt: skip
    assert np.array_equal(by_law.contact_force, force) and np.array_equal(frames.contact_force, force)
    np.testing.assert_allclose(measurement.potential_energy(frames), energy, rtol=1e-12)
    assert (force.min(), force.max()) != pytest.approx((20.0, 20.0), rel=0.1)
    assert frames.rest_force == pytest.approx(np.full(9, 20.0), rel=1e-12)


def test_a_contact_with_a_history_needs_its_recorded_force(tmp_path):
    with recorded(tmp_path / "without.mcap", "elastic_plastic", ["velocity", "displacement"]) as log:
        frames = measurement.history(log)
    with pytest.raises(LogError, match=r"law 'elastic_plastic'.*record with variables=.*'contact_force'"):
        _ = frames.contact_force
    with pytest.raises(LogError, match="law 'elastic_plastic'.*'potential_energy'"):
        measurement.potential_energy(frames)
    with recorded(tmp_path / "with.mcap", "elastic_plastic") as log:
        np.testing.assert_array_equal(measurement.history(log).contact_force, log.series("contact_force")[1])


@pytest.mark.parametrize("force", [0.0, 50.0])
def test_the_rest_state_of_a_plastic_contact_is_its_first_loading(force):
    """At 50 N these contacts have yielded, so the overlap follows from the tangent, not from Hertz's law."""
    chain = ge.make("chain", grains=4, law={"name": "elastic_plastic", "yield_pressure": 2e9}, precompression=force)
    frames = measurement.observe(chain, 1e-6, 1e-6)
    assert frames.rest_force[1:-1] == pytest.approx(np.full(3, force), rel=1e-12)


def test_energies_above_the_static_state_are_kept():
    """An inner impact in a precompressed chain of cones: kinetic plus excess contact energy equal the initial energy."""
    chain = ge.make("chain", grains=30, precompression=50.0, **LAWS["power"])
    chain.reset(velocity={2: 0.5})
    frames = measurement.observe(chain, 6e-5, 1e-6)
    assert frames.rest_energy[1:-1] == pytest.approx(np.full(29, 50.0**1.5 / 1e6 / 3.0), rel=1e-12)
    approach = np.nan_to_num(frames.overlap - frames.rest_overlap)
    above = frames.contact_energy - frames.rest_energy - frames.rest_force * approach
    total = measurement.kinetic_energy(frames) + above.sum(axis=1)
    assert total == pytest.approx(np.full(len(total), 0.125 * frames.mass[2]), rel=1e-6)
    waves = measurement.waves_along(frames, 6e-5, 0.01)
    assert 0.0 < sum(wave.potential_energy for wave in waves) <= above[-1].sum() * (1.0 + 1e-9)


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
def test_the_virial_ratio_is_that_of_the_exponent(exponent):
    """Between walls 2 <Ek> = <sum F d>, so <Ek>/<Ep> = (p + 1)/2; the deviation decreases with the length of the run."""
    law = {"name": "power", "exponent": exponent}
    chain = ge.make("chain", grains=3, left="plane", right="plane", law=law, contact_stiffness=1.0, mass=1.0, radius=100.0,
                    velocity_scale=1.0, overlap_limit=10.0, step_size=0.02)  # fmt: skip
    chain.reset(velocity=[1.0, -0.3, 0.2])
    frames = measurement.observe(chain, 4000.0, 0.1)
    ratio = measurement.kinetic_energy(frames).mean() / measurement.potential_energy(frames).mean()
    assert ratio == pytest.approx(0.5 * (exponent + 1.0), rel=2e-3)
