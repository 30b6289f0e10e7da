"""Measurements on synthetic histories with known waves, and their refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from granular_env.components.errors import LogError, ParameterError
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History

SPACING = 2.0
numbers = st.floats(0.5, 2.0)


def bell(x: np.ndarray) -> np.ndarray:
    return np.exp(-(x**2))


def travelling(
    waves: list[tuple[float, float, float]], grains: int = 40, end: float = 60.0, every: float = 0.15, sense: float = 1.0
) -> History:
    """Return a history of bell-shaped waves (amplitude, speed, delay) in unit masses 2 apart, without contact forces."""
    time = np.arange(0.0, end, every)
    position = SPACING * np.arange(grains)
    start = position if sense > 0.0 else position[::-1]
    velocity = sum(a * bell(time[:, None] - delay - start / speed) for a, speed, delay in waves)
    stiffness = np.ones(grains + 1)
    stiffness[[0, -1]] = 0.0
    return History(
        time, sense * velocity, np.ones(grains), stiffness, np.zeros(grains + 1), position, np.zeros((len(time), grains))
    )


def still(frames: int = 5, grains: int = 4, **changes: object) -> History:
    """Return a manual history: unit masses and contacts, walls at both ends."""
    parts: dict[str, object] = {
        "time": np.arange(float(frames)), "velocity": np.zeros((frames, grains)), "mass": np.ones(grains),
        "stiffness": np.ones(grains + 1), "rest_overlap": np.zeros(grains + 1), "position": np.arange(float(grains)),
        "displacement": np.zeros((frames, grains)),
    }  # fmt: skip
    return History(**(parts | changes))  # type: ignore[arg-type]


# -- crests ------------------------------------------------------------------------------------------------------------


@given(height=st.floats(0.1, 10.0), place=st.floats(4.0, 6.0), every=st.floats(0.05, 0.3))
def test_a_crest_between_the_samples(height: float, place: float, every: float) -> None:
    """The crest of exp(-t^2), about as long as a solitary wave in tau, is accurate to 1e-6 at 0.1 tau per sample."""
    time = np.arange(0.0, 10.0, every)
    (crest,) = measurement.crests(time, height * bell(time - place), 0.05)
    bound = 1e-6 * max(1.0, (every / 0.1) ** 7)
    assert crest.height == pytest.approx(height, rel=bound)
    assert crest.time == pytest.approx(place, abs=bound)
    assert crest.duration == pytest.approx(2.0 * math.sqrt(math.log(2.0)), abs=10.0 * bound)


def test_crests_of_a_polynomial_are_exact_even_on_uneven_samples() -> None:
    time = np.array([0.0, 0.3, 0.5, 1.1, 1.3, 1.9, 2.2, 2.9, 3.1])
    curve = np.polynomial.Polynomial.fromroots([-1.0, 4.0, 5.0, 9.0])  # one maximum near 4.48, one minimum near 1.1
    (crest,) = measurement.crests(time, 200.0 + curve(time) * -1.0, 1.0)
    near = [root for root in curve.deriv().roots() if 0.0 < root < 3.0]
    assert len(near) == 1
    assert crest.time == pytest.approx(near[0], abs=1e-9)
    assert crest.height == pytest.approx(200.0 - curve(near[0]), rel=1e-12)


def test_a_crest_ends_at_the_minimum_or_where_the_curve_is_not_positive() -> None:
    time = np.arange(11.0)
    values = np.array([-1.0, 0.0, 2.0, 5.0, 3.0, 1.0, 4.0, 3.0, -2.0, 1.0, 0.5])
    found = measurement.crests(time, values, 0.7)
    assert [(c.begin, c.end) for c in found] == [(1.0, 5.0), (5.0, 8.0), (8.0, 10.0)]
    assert [(c.begin, c.end) for c in measurement.crests(time, values, 2.0)] == [(1.0, 5.0), (5.0, 8.0)]


def test_separation_tells_waves_from_ripples() -> None:
    time = np.arange(9.0)
    values = np.array([0.0, 10.0, 7.9, 8.0, 4.0, 6.0, 0.0, 1.0, 0.0])

    def ends(separation: float) -> list[float]:
        return [crest.end for crest in measurement.crests(time, values, 0.5, separation)]

    assert ends(1.0) == [2.0, 4.0, 6.0, 8.0]
    # The curve falls to 7.9 of 8 between the first two crests, and to 4 of 6 before the third.
    assert ends(0.9) == [4.0, 6.0, 8.0]
    assert ends(0.5) == [6.0, 8.0]


# -- waves -------------------------------------------------------------------------------------------------------------


@given(amplitude=numbers, speed=numbers, sense=st.sampled_from([1.0, -1.0]))
def test_a_wave_at_a_grain(amplitude: float, speed: float, sense: float) -> None:
    direction = "right" if sense > 0.0 else "left"
    history = travelling([(amplitude, speed, 5.0)], grains=12, end=60.0, sense=sense)
    (wave,) = measurement.waves_at(history, 5, 0.1, direction=direction)
    way = SPACING * (5.0 if sense > 0.0 else 6.0)
    assert (wave.grain, wave.direction) == (5, direction)
    assert wave.amplitude == pytest.approx(amplitude, rel=1e-4)
    assert wave.time == pytest.approx(5.0 + way / speed, abs=1e-4)
    assert wave.speed == pytest.approx(speed, rel=1e-4)
    assert wave.duration == pytest.approx(2.0 * math.sqrt(math.log(2.0)), abs=1e-3)
    assert wave.width == wave.duration * wave.speed
    assert measurement.waves_at(history, 5, 0.1, direction="left" if sense > 0.0 else "right") == []
    assert measurement.waves_at(history, 5, 1.01 * amplitude, direction=direction) == []


def test_waves_are_counted_in_the_order_of_their_arrival() -> None:
    history = travelling([(1.0, 2.0, 5.0), (0.5, 1.5, 12.0), (0.2, 1.2, 22.0)])
    assert [round(w.amplitude, 3) for w in measurement.waves_at(history, 10, 0.1)] == [1.0, 0.5, 0.2]
    assert [round(w.amplitude, 3) for w in measurement.waves_at(history, 10, 0.3)] == [1.0, 0.5]
    assert [round(w.speed, 3) for w in measurement.waves_at(history, 10, 0.1)] == [2.0, 1.5, 1.2]


@given(shift=st.floats(-1.0, 1.0), change=st.floats(-0.1, 0.1))
def test_phase_shift(shift: float, change: float) -> None:
    alone = travelling([(1.0, 2.0, 5.0), (0.5, 1.5, 12.0)], grains=20)
    met = travelling([(1.0 + change, 2.0, 5.0 - shift), (0.5, 1.5, 12.0)], grains=20)
    first, second = measurement.phase_shifts(met, alone, 10, 0.1)
    assert first.advance == pytest.approx(shift, abs=2e-4)
    assert first.amplitude_change == pytest.approx(change, abs=2e-4)
    assert second == measurement.Shift(0.0, 0.0)


def test_waves_along_share_no_grain_and_lose_no_energy() -> None:
    history = travelling([(1.0, 2.0, 5.0), (0.5, 2.0, 12.0)], grains=40)
    waves = measurement.waves_along(history, 20.0, 0.1)
    assert [wave.grain for wave in waves] == [8, 15]
    assert waves[0].last + 1 == waves[1].first
    frame = history.frame_number(20.0)
    assert sum(wave.energy for wave in waves) == pytest.approx(0.5 * (history.velocity[frame] ** 2).sum(), rel=1e-6)
    assert sum(wave.momentum for wave in waves) == pytest.approx(history.velocity[frame].sum(), rel=1e-6)
    assert waves[1].position == pytest.approx(30.0, abs=0.1) and waves[0].position == pytest.approx(16.0, abs=0.1)


def test_a_contact_with_a_wall_belongs_to_the_end_grain() -> None:
    velocity, displacement = np.zeros((1, 4)), np.zeros((1, 4))
    velocity[0, [0, 3]], displacement[0, 3], displacement[0, 0] = 1.0, 0.09, -0.04
    first, last = measurement.waves_along(still(1, velocity=velocity, displacement=displacement), 0.0, 0.5)
    assert first.potential_energy == pytest.approx(0.4 * 0.2**5)
    assert last.potential_energy == pytest.approx(0.4 * 0.3**5)


# -- fronts ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", ["right", "left"])
def test_front(direction: str) -> None:
    sense = 1.0 if direction == "right" else -1.0
    history = travelling([(1.0, 1.6, 5.0)], grains=20, sense=sense)
    ends = (2, 17) if direction == "right" else (17, 2)
    assert measurement.front_speed(history, 0.5, *ends, direction=direction) == pytest.approx(1.6, rel=1e-5)
    seen = measurement.arrivals(history, 0.5, direction)
    first = 5.0 - math.sqrt(math.log(2.0))
    assert seen[:: int(sense)] == pytest.approx(first + SPACING * np.arange(20) / 1.6, abs=1e-5)
    front = measurement.front_position(history, 0.5, direction)
    inside = (history.time > first + 0.2) & (history.time < first + 20.0)
    travelled = 1.6 * (history.time[inside] - first)
    assert front[inside] == pytest.approx(travelled if sense > 0.0 else 38.0 - travelled, abs=1e-4)
    assert np.isnan(front[history.time < first]).all()


def test_a_front_that_never_comes() -> None:
    history = still()
    assert np.isnan(measurement.arrivals(history, 0.5)).all()
    assert np.isnan(measurement.front_position(history, 0.5)).all()
    with pytest.raises(ParameterError, match="does not reach grain 0"):
        measurement.front_speed(history, 0.5, 0, 3)


# -- energies ----------------------------------------------------------------------------------------------------------


def test_forces_and_energies_of_an_overlap() -> None:
    """Force k d^1.5 and energy 0.4 k d^2.5; grain 1 is shifted by 0.09 towards grain 2, with a gap of 0.05 on its left."""
    displacement = np.zeros((1, 3))
    displacement[0, 1] = 0.09
    history = still(
        1, 3, displacement=displacement, stiffness=np.array([0.0, 2.0, 3.0, 0.0]),
        rest_overlap=np.array([0.0, 0.04, 0.0, 0.0]),
    )  # fmt: skip
    assert history.overlap[0, 1:3] == pytest.approx([-0.05, 0.09])
    assert history.overlap[0, [0, 3]].tolist() == [0.0, 0.0]
    assert history.contact_force[0] == pytest.approx([0.0, 0.0, 3.0 * 0.027, 0.0])
    assert measurement.potential_energy(history) == pytest.approx([0.4 * 3.0 * 0.3**5])
    assert measurement.detached_grains(history).tolist() == [0]
    assert history.rest_force == pytest.approx([0.0, 2.0 * 0.008, 0.0, 0.0])


def test_kinetic_energy_and_momentum_with_and_without_a_piston() -> None:
    velocity = np.array([[2.0, -1.0, 3.0]])
    history = still(1, 3, velocity=velocity, mass=np.array([1.0, 2.0, 4.0]), piston=np.array([True, False, False]))
    assert measurement.kinetic_energy(history) == pytest.approx([2.0 + 1.0 + 18.0])
    assert measurement.kinetic_energy(history, piston=False) == pytest.approx([19.0])
    assert measurement.momentum(history) == pytest.approx([12.0])
    assert measurement.momentum(history, piston=False) == pytest.approx([10.0])


def test_energy_ratio_and_momentum_carried_off() -> None:
    velocity = np.array([[2.0, 0.0], [-0.5, 2.5], [-1.0, 3.0]])
    displacement = np.zeros((3, 2))
    displacement[:, 0] = 1.0
    stiffness = np.array([0.0, 1.0, 0.0])
    history = still(3, 2, velocity=velocity, displacement=displacement, stiffness=stiffness)
    ratio = measurement.energy_ratio(history, 0.0, 1.0)
    assert (ratio.least, ratio.greatest) == pytest.approx((2.0 / 0.4, 3.25 / 0.4))
    assert ratio.mean == pytest.approx(2.625 / 0.4) and ratio.deviation == pytest.approx(0.625 / 2.625)
    assert measurement.momentum_carried_off(history, 1.0) == pytest.approx(0.25)
    assert measurement.momentum_carried_off(history) == pytest.approx(0.5)
    mirrored = still(3, 2, velocity=-velocity, displacement=displacement, stiffness=stiffness)
    assert measurement.momentum_carried_off(mirrored) == pytest.approx(0.5)


# -- refusals ----------------------------------------------------------------------------------------------------------


def test_other_arguments_that_do_not_fit() -> None:
    history = travelling([(1.0, 2.0, 5.0)])
    for separation in (0.0, 1.1, "all"):
        with pytest.raises(ParameterError, match="separation: got"):
            measurement.waves_at(history, 10, 0.1, separation)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="direction: got 'up', expected 'right' or 'left'"):
        measurement.waves_at(history, 10, 0.1, direction="up")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="time: got 99.0 s; the history extends from 0 s to"):
        measurement.waves_along(history, 99.0, 0.1)
    with pytest.raises(ParameterError, match="window: it begins at 9 s"):
        measurement.energy_ratio(history, 9.0, 3.0)
    with pytest.raises(ParameterError, match="no contact is compressed at 0 s"):
        measurement.energy_ratio(history)
    with pytest.raises(ParameterError, match="crests: got times"):
        measurement.crests(np.arange(3.0), np.arange(4.0), 1.0)
    with pytest.raises(ParameterError, match="in this order"):
        measurement.front_speed(history, 0.5, 10, 5)
    with pytest.raises(ParameterError, match="reference: no wave above 0.1 m/s passes grain 10"):
        measurement.phase_shifts(history, travelling([(0.01, 2.0, 5.0)]), 10, 0.1)
    with pytest.raises(ParameterError, match="momentum of the chain in its first frame is zero"):
        measurement.momentum_carried_off(still())
    with pytest.raises(ParameterError, match="has no maximum in this history"):
        measurement.pressure_ratio(history, 10)
    wave = measurement.waves_at(history, 0, 0.1)[0]
    with pytest.raises(ParameterError, match="grain 0 has no contact on the side from which a wave travelling right arrives"):
        measurement.energy_of(history, wave)


def test_velocities_alone_give_waves_but_no_energies() -> None:
    history = still(displacement=None)
    assert measurement.waves_at(history, 1, 0.1) == []
    for refused in (measurement.potential_energy, measurement.energy_ratio, measurement.detached_grains):
        with pytest.raises(LogError, match=r"displacement was not recorded.*variables=\['velocity', 'displacement'\]"):
            refused(history)
