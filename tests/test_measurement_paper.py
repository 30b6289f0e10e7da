"""Nesterenko (1983), sections 3.1 to 3.4, measured on the shipped experiments, against recomputed values.

The reference integrator runs the experiments unchanged. The values are those of the chain; if the paper prints other values,
tests/test_chain_paper.py states both.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.chain_tools import SPEED, paper_chain, unit_chain

import granular_env as ge
from granular_env.components.errors import LogError, ParameterError
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History

pytestmark = pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")

EVERY = 5e-7


@cache
def solitary() -> History:
    """Return one grain striking a chain with m = A = v0 = 1: a single solitary wave, sampled at 0.1 tau."""
    chain = unit_chain(200, step_size=0.02)
    chain.reset(velocity={0: 1.0})
    return measurement.observe(chain, 280.0, 0.1)


# -- 3.1 ---------------------------------------------------------------------------------------------------------------


# -- 3.2 ---------------------------------------------------------------------------------------------------------------


# -- 3.3 ---------------------------------------------------------------------------------------------------------------


# -- 3.4 ---------------------------------------------------------------------------------------------------------------


# -- the solitary wave -------------------------------------------------------------------------------------------------


def test_the_uncompressed_solitary_wave() -> None:
    history = solitary()
    wave = measurement.waves_at(history, 80, 0.3)[0]
    top = wave.amplitude
    assert top == pytest.approx(0.681632, abs=1e-6)
    assert wave.speed / 200.0 / top**0.2 == pytest.approx(0.907470, abs=1e-6)
    assert measurement.energy_of(history, wave) / top**2 == pytest.approx(1.06932, abs=1e-5)
    assert measurement.momentum_of(history, wave) / top == pytest.approx(1.66997, abs=1e-5)
    overlap = measurement.overlap_of(history, wave)
    assert overlap.duration * wave.speed / 200.0 == pytest.approx(1.7257, abs=1e-4)
    assert history.velocity[-1, -1] / top == pytest.approx(1.44606, abs=1e-5)


def test_energy_in_a_wave_along_the_chain_is_that_which_passes_a_grain() -> None:
    history = solitary()
    wave = measurement.waves_at(history, 80, 0.3)[0]
    end = measurement.waves_at(history, 110, 0.3)[0].time
    times = history.time[(history.time >= wave.time) & (history.time < end)]
    found = [measurement.waves_along(history, time, 0.3) for time in times]
    assert {len(waves) for waves in found} == {1}
    energy = np.array([waves[0].energy for waves in found])
    assert np.ptp(energy) < 1e-9 and energy[0] == pytest.approx(measurement.energy_of(history, wave), rel=1e-7)
    assert found[0][0].momentum == pytest.approx(measurement.momentum_of(history, wave), rel=1e-7)
    kinetic, potential = (np.array([getattr(w[0], f"{kind}_energy") for w in found]) for kind in ("kinetic", "potential"))
    # After thirty grains the ratio of the means is the virial theorem's 5/4, and the mean of the ratio slightly larger.
    assert kinetic.mean() / potential.mean() == pytest.approx(1.25, abs=1e-4)
    assert (kinetic / potential).mean() == pytest.approx(1.2508, abs=1e-4)
    lowest = min(waves[0].amplitude for waves in found) / wave.amplitude
    assert lowest > 0.75


def test_a_wave_on_a_precompressed_chain_carries_its_energy_above_the_static_one() -> None:
    """The energy that passes grain 40 is the chain's energy between the minima; the tolerances allow for overlapping waves."""
    chain = paper_chain(120, precompression=20.0, step_size=EVERY)
    history = measurement.observe(chain, 4e-4, EVERY, left_force=ge.Profile.half_sine(400.0, 4e-5))
    wave = measurement.waves_at(history, 40, 0.3)[0]
    along = max(measurement.waves_along(history, wave.time, 0.3), key=lambda found: found.amplitude)
    assert measurement.energy_of(history, wave) == pytest.approx(along.energy, rel=1e-3)
    assert measurement.momentum_of(history, wave) == pytest.approx(along.momentum, rel=5e-3)
    # Most of the work of the force pulse.
    assert 0.7 * chain.get("input_work") < along.energy < chain.get("input_work")


# -- logs and running chains -------------------------------------------------------------------------------------------


def record(path: Path, run: Callable[[ge.Component], None], **options: object) -> ge.Component:
    chain = paper_chain(30, integrator="pefrl")
    with ge.record(chain, path, every=EVERY, **options):  # type: ignore[arg-type]
        run(chain)
    return chain


def strike(chain: ge.Component) -> None:
    chain.reset(velocity={0: SPEED})
    chain.step(1e-4)
    chain.step(6e-5, left_force=10.0)


@pytest.mark.parametrize(
    "names", [["velocity", "displacement"], ["velocity", "overlap"], ["overlap", "displacement", "velocity"]]
)
def test_a_log_and_a_running_chain_give_the_same(tmp_path: Path, names: list[str]) -> None:
    record(tmp_path / "run.mcap", strike, variables=names)
    with ge.open_log(tmp_path / "run.mcap") as log:
        logged = measurement.history(log)
        kinetic, potential = log.series("kinetic_energy")[1], log.series("potential_energy")[1]
    watch = measurement.Watch(EVERY)
    chain = paper_chain(30, integrator="pefrl")
    chain.observe(watch)
    strike(chain)
    live = watch.history
    for name in ("time", "velocity", "overlap", "contact_force", "mass", "stiffness", "position"):
        assert np.array_equal(getattr(logged, name), getattr(live, name)), name
    assert measurement.waves_at(logged, 20, 0.1) == measurement.waves_at(live, 20, 0.1) != []
    assert measurement.energy_ratio(logged, 2e-5) == measurement.energy_ratio(live, 2e-5)
    # The chain's energy balance agrees.
    assert measurement.kinetic_energy(logged) == pytest.approx(kinetic, rel=1e-13)
    assert measurement.potential_energy(logged) == pytest.approx(potential, rel=1e-12, abs=1e-20)
    forces = chain.get("contact_force")
    assert live.contact_force[-1] == pytest.approx(forces, rel=1e-12)


def test_watching_changes_no_bit() -> None:
    watched, alone = (paper_chain(30, integrator="pefrl") for _ in range(2))
    push = ge.Profile.half_sine(100.0, 2e-5)
    for chain in (watched, alone):
        chain.reset(velocity={0: SPEED})
    measurement.observe(watched, 1e-4, 3 * EVERY, left_force=push)
    alone.step(1e-4, left_force=push)
    assert watched.save().to_bytes() == alone.save().to_bytes()


def test_a_step_that_fails_leaves_no_frames() -> None:
    chain = paper_chain(10, integrator="pefrl")
    watch = measurement.Watch(EVERY)
    chain.observe(watch)
    chain.reset(velocity={0: SPEED})
    chain.step(1e-5)
    frames = len(watch.history.time)
    with pytest.raises(ge.StepError):
        chain.step(1e-4, left_force=ge.Profile.triangle(1e9, 1e-5, start=5e-5))
    assert len(watch.history.time) == frames
    chain.step(1e-5, left_force=0.0)
    assert np.diff(watch.history.time) == pytest.approx(EVERY)


def test_runs_in_one_log_are_told_apart(tmp_path: Path) -> None:
    def twice(chain: ge.Component) -> None:
        for speed in (1.0, 2.0, 3.0):
            chain.reset(velocity={0: speed})
            chain.step(2e-5)

    record(tmp_path / "run.mcap", twice)
    with ge.open_log(tmp_path / "run.mcap") as log:
        with pytest.raises(LogError, match="contains 3 runs.*segment = 0 to 2"):
            measurement.history(log)
        with pytest.raises(ParameterError, match="segment: got 3, expected a whole number from 0 to 2"):
            measurement.history(log, 3)
        for number, speed in enumerate((1.0, 2.0, 3.0)):
            one = measurement.history(log, number)
            assert one.velocity[0, 0] == speed and len(one.time) == 41
            assert one.time[0] == pytest.approx(number * 2e-5)


def test_logs_that_cannot_be_measured(tmp_path: Path) -> None:
    record(tmp_path / "overlap.mcap", strike, variables=["overlap"])
    with (
        ge.open_log(tmp_path / "overlap.mcap") as log,
        pytest.raises(LogError, match=r"velocity was not recorded.*variables=\['velocity', 'displacement'\]"),
    ):
        measurement.history(log)
    record(tmp_path / "velocity.mcap", strike, variables=["velocity"])
    with ge.open_log(tmp_path / "velocity.mcap") as log:
        history = measurement.history(log)
    assert len(measurement.waves_at(history, 20, 0.1)) == 1
    with pytest.raises(LogError, match=r"displacement was not recorded.*variables=\['velocity', 'displacement'\]"):
        measurement.energy_of(history, measurement.waves_at(history, 20, 0.1)[0])
    oscillator = ge.make("oscillator")
    with ge.record(oscillator, tmp_path / "oscillator.mcap"):
        oscillator.step(0.1)
    with (
        ge.open_log(tmp_path / "oscillator.mcap") as log,
        pytest.raises(LogError, match="is of 'oscillator', expected a chain"),
    ):
        measurement.history(log)


# -- chains of unequal grains --------------------------------------------------------------------------------------------


def struck_cells(*parts: float) -> measurement.History:
    """Return the motion of a struck chain of equal cells; `parts` are the grains' masses in masses of a steel grain."""
    kinds = [ge.Material(density=7800.0 * part, young=2e11, poisson=0.29) for part in parts]
    count = 48
    chain = ge.make("chain", grains=count, radius=3e-3, material=(kinds * count)[:count], velocity_scale=0.2, step_size=1e-7)
    chain.reset(velocity={0: 0.1})
    return measurement.observe(chain, duration=6e-4, every=5e-7)


@pytest.mark.parametrize(
    "parts", [(1.0, 0.59), (1.0, 0.3428), (1.0, 0.24), (1.0, 0.1548), (1.0, 0.1), (1.0, 1.0, 0.24), (1.0, 0.24, 0.24)]
)
def test_the_speed_in_a_chain_of_cells_is_that_of_the_wave_or_not_known(parts: tuple[float, ...]) -> None:
    """Light grains have several crests in one pulse. Speeds from crests agree within 1 % with arrivals one cell apart."""
    history, cell = struck_cells(*parts), len(parts)
    arrivals = measurement.arrivals(history, above=0.01)
    for grain in range(24, 24 + cell):
        speed = (history.position[grain + cell] - history.position[grain - cell]) / (
            arrivals[grain + cell] - arrivals[grain - cell]
        )
        for separation in (1.0, 0.5):
            waves = measurement.waves_at(history, grain, 0.03, separation, period=cell)
            assert waves
            speeds = np.array([wave.speed for wave in waves])
            assert np.all(np.isnan(speeds) | (np.abs(speeds / speed - 1.0) < 0.01))
            assert np.isfinite(speeds).all() or parts[grain % cell] < 1.0 or separation == 1.0
            # Crests in the same pulse share its energy and momentum; counting the pulse for each crest would double the sums.
            force, velocity = history.contact_force[:, grain], history.velocity[:, grain]
            work, impulse = (np.trapezoid(force * factor, history.time) for factor in (velocity, 1.0))
            assert sum(measurement.energy_of(history, wave) for wave in waves) < 1.02 * work
            assert sum(measurement.momentum_of(history, wave) for wave in waves) < 1.02 * impulse
            if cell == 2:
                # Unequal neighbours must not give a wrong speed either.
                nearest = np.array([wave.speed for wave in measurement.waves_at(history, grain, 0.03, separation)])
                assert np.all(np.isnan(nearest) | (np.abs(nearest / speed - 1.0) < 0.02))
