"""Input signals: shapes, conversion to ticks, refusals."""

from __future__ import annotations

import math
import warnings
from contextlib import nullcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.work import count_calls

import granular_env as ge
from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.profiles import CompiledProfile, Profile

H = 0.01
# The same polynomial, in seconds and in ticks, gives each tick's value; the difference is the rounding of a few operations.
ROUNDING = 1e-12


def sampled(compiled: CompiledProfile, ticks: int, part: float = 0.0) -> list[float]:
    return [compiled.value(tick, part) for tick in range(ticks)]


# -- shapes -----------------------------------------------------------------------------------------------------------


def test_falling_triangle_starts_at_its_peak() -> None:
    profile = Profile.triangle(8.0, 0.4)
    assert [profile(t) for t in (0.0, 0.1, 0.2, 0.3)] == pytest.approx([8.0, 6.0, 4.0, 2.0], rel=1e-15)
    assert profile(0.4) == profile(1.0) == 0.0


def test_triangle_rises_and_falls() -> None:
    profile = Profile.triangle(8.0, 0.5, rise=0.1, start=1.0)
    assert [profile(t) for t in (0.9, 1.0, 1.05, 1.1, 1.3, 1.5)] == pytest.approx([0.0, 0.0, 4.0, 8.0, 4.0, 0.0], abs=1e-14)


def test_half_sine_is_as_exact_as_it_says() -> None:
    profile = Profile.half_sine(3.0, 2.0, start=0.5)
    times = np.linspace(0.0, 2.0, 20001)[:-1]
    errors = [abs(profile(0.5 + t) - 3.0 * math.sin(math.pi * t / 2.0)) / 3.0 for t in times]
    # The first neglected Taylor term, pi^25 / 25! = 1.7e-13, plus rounding. The lower bound shows that it is reached.
    assert 1e-13 < max(errors) <= 1.8e-13  # the series is cut at pi^25 / 25!
    assert profile(0.4) == profile(2.5) == profile(9.0) == 0.0


def test_table_joins_samples_by_straight_lines() -> None:
    profile = Profile.table([0.0, 1.0, 3.0], [2.0, 4.0, -2.0])
    assert [profile(t) for t in (0.0, 0.5, 1.0, 2.0)] == pytest.approx([2.0, 3.0, 4.0, 1.0], rel=1e-15)


def test_piecewise_takes_polynomials_of_unlike_degree() -> None:
    profile = Profile.piecewise([0.0, 1.0, 2.0], [[1.0], [0.0, 2.0, 3.0], [0.0]])
    assert [profile(t) for t in (0.5, 1.0, 1.5, 2.0)] == [1.0, 0.0, 1.75, 0.0]


finite = st.floats(-1e3, 1e3)
spans = st.floats(0.01, 10.0)
constants = st.builds(Profile.constant, finite, start=st.floats(0.0, 5.0))
shapes = st.one_of(
    constants,
    st.builds(
        lambda peak, span, share, start: Profile.triangle(peak, span, share * span, start),
        finite,
        spans,
        st.floats(0.0, 1.0),
        spans,
    ),
    st.builds(Profile.half_sine, finite, spans, start=spans),
    st.builds(
        lambda values, gap: Profile.table(gap * np.arange(len(values)), values, "hold"),
        st.lists(finite, min_size=2, max_size=6),
        spans,
    ),
)


@given(st.lists(shapes, min_size=1, max_size=4), st.floats(0.0, 20.0))
def test_a_sum_is_the_sum(profiles: list[Profile], time: float) -> None:
    starts = np.concatenate([profile.starts for profile in profiles])
    # Breakpoints that differ only by rounding count as one.
    assume(not ((starts != time) & (np.abs(starts - time) <= 1e-13 * np.abs(starts).max())).any())
    expected = sum(profile(time) for profile in profiles)
    # Re-centring a half-sine's 24 coefficients inside its span costs rounding of at most their largest term, pi^3 / 3! = 5.2
    # peaks, times 24 times 1.1e-16 on each side: 3e-14 of the sum of peaks (1e3 each).
    assert Profile.total(profiles)(time) == pytest.approx(expected, abs=1e-10)


def recentred(profile: Profile, time: float) -> list[float]:
    """Return coefficients about a time, by synthetic division of floats."""
    piece = int(np.searchsorted(profile.starts, time, side="right")) - 1
    if piece < 0:
        return [0.0]
    numbers, offset = profile.coefficients[piece].tolist(), time - float(profile.starts[piece])
    for first in range(len(numbers) - 1):
        for index in range(len(numbers) - 2, first - 1, -1):
            numbers[index] += offset * numbers[index + 1]
    return numbers


def test_a_sum_adds_recentred_polynomials_bit_for_bit() -> None:
    parts = [
        Profile.half_sine(3.0, 7e-5, 1.3e-5),
        Profile.table([0.0, 1e-5, 3.3e-5], [0.0, 2.0, 5.0], after="hold"),
        Profile.triangle(5.0, 4e-5, 1e-5, 2e-5),
    ]
    total = Profile.total(parts)
    assert total.starts.tolist() == sorted({time for part in parts for time in part.starts.tolist()})
    for start, row in zip(total.starts.tolist(), total.coefficients, strict=True):
        expected = np.zeros(len(row))
        for part in parts:
            numbers = recentred(part, start)
            expected[: len(numbers)] += numbers
        assert row.tobytes() == expected.tobytes()
    assert (parts[0] + parts[1]).coefficients.tobytes() == Profile.total(parts[:2]).coefficients.tobytes()


def test_a_sum_of_many_takes_work_in_proportion_and_has_no_slivers() -> None:
    # k * 1e-5 + 1e-5 and (k + 1) * 1e-5 are the same time but differ in the last bit for some k.
    parts = [Profile.half_sine(1.0, 1e-5, k * 1e-5) for k in range(3000)]
    total = Profile.total(parts)
    # Adding profiles one by one would take a hundred times the work for ten times the number.
    few, many = (count_calls(lambda count=count: Profile.total(parts[:count])) for count in (300, 3000))
    assert many < 15 * few
    assert len(total.starts) == 3001
    assert np.diff(total.starts).min() > 0.999e-5
    assert [total(t) for t in (0.5e-5, 0.01234567)] == pytest.approx([1.0, math.sin(0.567 * math.pi)], abs=1e-9)
    assert len(repr(total)) < 200 and total.description == "sum of 3000 profiles"
    twice = total + total
    assert twice.starts.tobytes() == total.starts.tobytes()
    assert twice.coefficients.tobytes() == (2.0 * total).coefficients.tobytes()


# -- on ticks ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "profile",
    [
        Profile.triangle(3.0, 20 * H, rise=5 * H, start=2 * H),
        Profile.half_sine(3.0, 20 * H, start=2 * H),
        Profile.table([0.0, 7 * H, 12 * H], [1.0, -1.0, 2.0], "hold"),
        Profile.triangle(3.0, 20 * H) + Profile.half_sine(1.0, 12 * H, start=3 * H),
    ],
    ids=lambda profile: profile.description,
)
def test_breakpoints_on_ticks_are_kept_without_a_warning(profile: Profile) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compiled = profile.compile(H)
    np.testing.assert_array_equal(compiled.ticks, np.rint(profile.starts / H))
    assert (
        compiled.coefficients.tobytes()
        == (profile.coefficients * np.cumprod([1.0, *[H] * 31])[: profile.coefficients.shape[1]]).tobytes()
    )
    for part in (0.0, 0.25, 0.5):
        expected = [profile((tick + part + 1e-13) * H) for tick in range(30)]
        # A shift of 1e-13 ticks puts times on the right side of a breakpoint; slopes are at most 3 per 5 ticks.
        assert sampled(compiled, 30, part) == pytest.approx(expected, abs=ROUNDING)


def integral(profile: Profile, begin: float, end: float) -> Fraction:
    """Return the exact integral of a profile of numbers."""
    total, ends = Fraction(0), [*profile.starts[1:].tolist(), math.inf]
    for start, stop, row in zip(profile.starts.tolist(), ends, profile.coefficients.tolist(), strict=True):
        if max(start, begin) < min(stop, end):
            low, high = (Fraction(time) - Fraction(start) for time in (max(start, begin), min(stop, end)))
            total += sum(Fraction(c) * (high**k - low**k) / k for k, c in enumerate(row, start=1) if c)
    return total


def noise(rate: float) -> Profile:
    samples = np.random.default_rng(5).normal(50.0, 2.0, round(1e-4 * rate) + 1)
    return Profile.table(np.arange(len(samples)) / rate, samples)


BETWEEN_TICKS = {
    "pulse sampled at 0.5 us": Profile.table(np.arange(9) * 5e-7 + 1.1e-5, [0, 10, 40, 80, 100, 70, 20, 5, 0]),
    "falling triangle": Profile.triangle(100.0, 1e-5, start=1.5e-6),
    "half sine of 10 us from 1.4 us": Profile.half_sine(100.0, 1e-5, start=1.4e-6),
    "half sine of 0.7 us": Profile.half_sine(100.0, 7e-7, start=2.2e-6),
    "white noise at 100 MS/s": noise(1e8),
    "uneven samples": Profile.table(np.cumsum(np.random.default_rng(2).uniform(1e-8, 4e-6, 60)), np.arange(60) % 7, "hold"),
    "begun before time 0": Profile.table([-3.3e-6, 1.2e-6, 9.9e-6], [3.0, -1.0, 4.0]),
    "two jumps in one tick": Profile.piecewise([0.0, 1.2e-5, 1.3e-5], [[1.0], [1e6], [-2.0]]),
    "triangle on a constant": Profile.constant(10.0) + Profile.triangle(8.0, 7.7e-6, 3.1e-6, 2.6e-6),
}


@pytest.mark.parametrize("step_size", [1e-6, 7.3e-6])
@pytest.mark.parametrize("profile", BETWEEN_TICKS.values(), ids=BETWEEN_TICKS)
def test_breakpoints_between_ticks_keep_the_impulse_of_every_tick_and_the_range(profile: Profile, step_size: float) -> None:
    with pytest.warns(GranularWarning, match="lie between ticks") if step_size != 1e-6 else nullcontext():
        compiled = profile.compile(step_size)
    ticks = round(1.1e-4 / step_size)
    exact = [float(integral(profile, tick * step_size, (tick + 1) * step_size)) for tick in range(ticks)]
    # Times in ticks are rounded to 1e-16 of at most 150 ticks, at each of at most two jumps per tick.
    scale = np.abs(exact).max()
    np.testing.assert_allclose(step_size * compiled.mean_factors(0, ticks), exact, rtol=0.0, atol=1e-13 * scale)
    edges = [float(value) for time in profile.starts for value in (profile(time), profile(math.nextafter(time, -1.0)))]
    low, high = min(0.0, *edges), max(0.0, *edges, 100.0 * ("half" in profile.description))
    values = [compiled.value(tick, part) for tick in range(ticks) for part in (0.0, 0.25, 0.5, 0.75, 1.0 - 1e-9)]
    # The truncation error of a half sine is 1.8e-13 of its peak.
    assert low - 1e-12 * (high - low) <= min(values) and max(values) <= high + 1e-12 * (high - low)


def test_only_ticks_with_a_breakpoint_inside_are_averaged() -> None:
    profile = Profile.piecewise([0.0, 3.4 * H, 19.7 * H], [[1.0, 2.0], [5.0, -3.0, 40.0], [0.5]])
    with pytest.warns(GranularWarning, match=r"left_force: 2 of 3 breakpoints.*of 0\.01 s, and 0 curves.*2 ticks use the mean"):
        compiled = profile.compile(H, "left_force")
    assert compiled.ticks.tolist() == [0, 3, 4, 19, 20]
    for tick in (0, 1, 2, 4, 5, 18, 20, 21):
        for part in (0.0, 0.5):
            assert compiled.value(tick, part) == pytest.approx(profile((tick + part) * H), rel=ROUNDING)
    assert compiled.value(3, 0.1) == compiled.value(3, 0.9) == pytest.approx(float(integral(profile, 3 * H, 4 * H)) / H)


@pytest.mark.parametrize("parts", [1, 3])
def test_a_mean_is_that_of_the_polynomial(parts: int) -> None:
    compiled, angle = Profile.half_sine(3.0, 12 * H, start=H).compile(H), math.pi / 12
    for tick in range(14):
        for part in range(parts):
            begin, end = tick - 1 + part / parts, tick - 1 + (part + 1) / parts
            exact = 0.0 if tick in (0, 13) else 3.0 / angle * parts * (math.cos(angle * begin) - math.cos(angle * end))
            assert compiled.mean(tick, part, parts) == pytest.approx(exact, abs=1e-12)
    assert compiled.mean_factors(0, 14).tolist() == [compiled.mean(tick) for tick in range(14)]
    line = Profile.table([0.0, 7 * H], [1.0, -1.3]).compile(H)
    assert [line.mean(tick) for tick in range(9)] == [line.value(tick, 0.5) for tick in range(9)]


@pytest.mark.parametrize("ticks", [0.3, 1, 2, 20])
@pytest.mark.parametrize("name", ["oscillator", "discs", "grid", "automata"])
def test_a_free_body_gains_the_impulse_of_its_half_sine(name: str, ticks: float) -> None:
    share, steel = [[0.6, 0.8]], {"density": 7800.0, "young": 2e11, "poisson": 0.3}
    square = {"name": "rectangle", "width": 0.03, "height": 0.03}
    mesh = {"name": "rectangle", "columns": 2, "rows": 2, "cell_size": 0.01}
    parameters = {
        "oscillator": {"mass": 1.0, "stiffness": 0.0, "step_size": H},
        "discs": {"columns": 1, "rows": 1, "step_size": 1e-5},
        "grid": {"mesh": mesh, "material": steel, "forced_nodes": [4]},
        "automata": {"shape": square, "packing": "square", "diameter": 0.01, "material": steel, "forced_automata": [4]},
    }
    body, pattern = ge.make(name, **parameters[name]), 1.0 if name == "oscillator" else share
    h = body.step_size
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        body.step(24 * h, force=Profile.half_sine(1e-3, ticks * h, start=2 * h) * pattern)
    impulse = body.get("velocity") if name == "oscillator" else body.get("momentum")[:2]
    # About a hundred additions, each rounded to 1e-16 of the largest momentum of a part.
    assert np.linalg.norm(impulse) == pytest.approx(2e-3 / math.pi * ticks * h, rel=1e-12)


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
@pytest.mark.parametrize("ticks", [0.3, 1, 2, 7.3])
@pytest.mark.parametrize("name", ["grid", "automata", "coupled"])
def test_an_edge_moves_by_the_integral_of_its_velocity(name: str, ticks: float) -> None:
    square = {"name": "rectangle", "width": 0.03, "height": 0.03}
    grid = {"mesh": {"name": "rectangle", "columns": 3, "rows": 2, "cell_size": 0.01}, "boundaries": {"bottom": "velocity"}}
    automata = {"shape": square, "packing": "square", "diameter": 0.01, "boundaries": {"top": "velocity"}}
    parts = {"grid": grid, "automata": automata, "origin": [0.0, 0.02], "micro_steps": 3}
    body = ge.make(name, **{"grid": grid, "automata": automata, "coupled": parts}[name])
    edges = {"grid": ["bottom"], "automata": ["top"], "coupled": ["grid_bottom", "automata_top"]}[name]
    h = body.step_size
    motion = Profile.half_sine(1.0, ticks * h, start=2.2 * h) * [1.0, -0.5]
    body.step(24 * h, **{f"{edge}_velocity": motion for edge in edges})
    moved = (
        [body.get("displacement")[0 if name == "grid" else -1]]
        if name != "coupled"
        else [body.get("grid_displacement")[0], body.get("automata_displacement")[-1]]
    )
    for displacement in moved:
        np.testing.assert_allclose(displacement, np.array([2.0, -1.0]) / math.pi * ticks * h, rtol=1e-12)


def test_a_chain_keeps_the_impulse_and_its_piston_the_displacement_of_short_pulses() -> None:
    samples = BETWEEN_TICKS["pulse sampled at 0.5 us"]
    exact = float(integral(samples, 0.0, 1.0))
    with pytest.warns(GranularWarning, match="between ticks"):
        pushed = ge.make("chain", grains=3, step_size=5e-6)
        pushed.step(5e-5, left_force=samples)
        driven = ge.make("chain", grains=3, left="piston", step_size=5e-6)
        driven.step(5e-5, left_velocity=1e-3 * samples)
    assert pushed.get("momentum") == pytest.approx(exact, rel=1e-12)
    assert driven.get("displacement")[0] == pytest.approx(1e-3 * exact, rel=1e-12)


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_profiles_between_ticks_step_alike_in_any_division_and_across_a_restore() -> None:
    push = BETWEEN_TICKS["uneven samples"]
    whole, divided, restored = (ge.make("chain", grains=3, step_size=5e-6) for _ in range(3))
    whole.step(2e-4, left_force=push)
    divided.step(5e-6, left_force=push)
    for _ in range(17):
        divided.step(5e-6)
    restored.restore(ge.Snapshot.from_bytes(divided.save().to_bytes()))
    for chain in (divided, restored):
        chain.step(22 * 5e-6)
        assert chain.save().to_bytes() == whole.save().to_bytes()


@given(shapes)
def test_a_driven_component_feels_the_integral(profile: Profile) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        body = Oscillator(mass=1.0, stiffness=0.0, step_size=H)
        body.step(200 * H, force=profile)
        scale = H * np.abs(profile.compile(H).mean_factors(0, 200)).sum()
    assert body.get("velocity") == pytest.approx(float(integral(profile, 0.0, 200 * H)), abs=1e-12 * scale + 1e-300)


# -- refusals ---------------------------------------------------------------------------------------------------------

NAN, HUGE = math.nan, 10**400


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Profile.triangle(1.0, 0.0), "duration: got 0, expected more than 0"),
        (lambda: Profile.triangle(1.0, 1.0, rise=2.0), "rise: got 2 s"),
        (
            lambda: Profile.triangle(1.0, 1e-30, start=1.0),
            "duration: got 1e-30 s, less than the rounding error",
        ),
        (lambda: Profile.table([0.0], [1.0]), "times: got 1 sample"),
        (lambda: Profile.table([0.0, 2.0, 1.0], [1.0, 1.0, 1.0]), r"times\[2\]: 1 s follows 2 s"),
        (lambda: Profile.table([0.0, NAN], [1.0, 1.0]), r"times\[1\]: got nan"),
        (
            lambda: Profile.piecewise([0.0], [[1.0], [2.0]]),
            "coefficients: got an array of shape .2, 1. for 1 starts",
        ),
        (lambda: Profile.piecewise([0.0], [[1.0] * 40]), "coefficients: got degree 39, expected at most 31"),
        (lambda: Profile.piecewise([0.0], [[[1.0]]]), "coefficients: got an array of shape"),
        (lambda: Profile(np.zeros(1), np.full((1, 2), NAN)), r"coefficients\[0,0\]: got nan"),
        (lambda: Profile.total(3), "profiles: got 3, expected a list of at least one Profile"),
    ],
)
def test_wrong_profiles_are_refused(make, words: str) -> None:  # noqa: ANN001
    with pytest.raises(ParameterError, match=words):
        make()
