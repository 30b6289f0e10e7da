"""Input signals: what each shape is, how it is brought onto ticks, what is refused."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.work import count_calls

from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.profiles import CompiledProfile, Profile

H = 0.01
# Each tick's value is reached in seconds and in ticks by the same polynomial: rounding of a few operations.
ROUNDING = 1e-12


def sampled(compiled: CompiledProfile, ticks: int, part: float = 0.0) -> list[float]:
    return [compiled.value(tick, part) for tick in range(ticks)]


# -- shapes -----------------------------------------------------------------------------------------------------------


def test_constant() -> None:
    profile = Profile.constant(2.5, start=0.1)
    assert [profile(t) for t in (-1.0, 0.0, 0.0999, 0.1, 5.0)] == [0.0, 0.0, 0.0, 2.5, 2.5]


def test_falling_triangle_starts_at_its_peak() -> None:
    profile = Profile.triangle(8.0, 0.4)
    assert [profile(t) for t in (0.0, 0.1, 0.2, 0.3)] == pytest.approx([8.0, 6.0, 4.0, 2.0], rel=1e-15)
    assert profile(0.4) == profile(1.0) == 0.0


def test_triangle_rises_and_falls() -> None:
    profile = Profile.triangle(8.0, 0.5, rise=0.1, start=1.0)
    assert [profile(t) for t in (0.9, 1.0, 1.05, 1.1, 1.3, 1.5)] == pytest.approx([0.0, 0.0, 4.0, 8.0, 4.0, 0.0], abs=1e-14)


def test_triangle_that_only_rises_drops_at_its_end() -> None:
    profile = Profile.triangle(8.0, 0.5, rise=0.5)
    assert profile(0.5 - 1e-12) == pytest.approx(8.0)
    assert profile(0.5) == 0.0


def test_half_sine_is_as_exact_as_it_says() -> None:
    profile = Profile.half_sine(3.0, 2.0, start=0.5)
    times = np.linspace(0.0, 2.0, 20001)[:-1]
    errors = [abs(profile(0.5 + t) - 3.0 * math.sin(math.pi * t / 2.0)) / 3.0 for t in times]
    # The cut-off Taylor term pi^25 / 25! = 1.7e-13, and rounding; it is reached, so the stated figure is not idle.
    assert 1e-13 < max(errors) <= 1.8e-13  # the series is cut at pi^25 / 25!
    assert profile(0.4) == profile(2.5) == profile(9.0) == 0.0


def test_table_joins_samples_by_straight_lines() -> None:
    profile = Profile.table([0.0, 1.0, 3.0], [2.0, 4.0, -2.0])
    assert [profile(t) for t in (0.0, 0.5, 1.0, 2.0)] == pytest.approx([2.0, 3.0, 4.0, 1.0], rel=1e-15)


@pytest.mark.parametrize(("after", "value"), [(0.0, 0.0), ("hold", -2.0), (7.0, 7.0)])
def test_table_goes_on_as_asked(after: float | str, value: float) -> None:
    profile = Profile.table([0.0, 1.0, 3.0], [2.0, 4.0, -2.0], after=after)
    assert profile(3.0) == profile(100.0) == value


def test_piecewise_takes_polynomials_of_unlike_degree() -> None:
    profile = Profile.piecewise([0.0, 1.0, 2.0], [[1.0], [0.0, 2.0, 3.0], [0.0]])
    assert [profile(t) for t in (0.5, 1.0, 1.5, 2.0)] == [1.0, 0.0, 1.75, 0.0]


def test_numpy_rows_and_plain_numbers_make_pieces_too() -> None:
    profile = Profile.piecewise(np.array([0.0, 1.0]), np.array([[1.0, 2.0], [3.0, 0.0]]))
    assert profile(0.5) == 2.0
    assert Profile.piecewise([0.0, 1.0], [4.0, 5.0])(1.0) == 5.0


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
    # Breakpoints that rounding alone tells apart are one.
    assume(not ((starts != time) & (np.abs(starts - time) <= 1e-13 * np.abs(starts).max())).any())
    expected = sum(profile(time) for profile in profiles)
    # Re-centring a half-sine's 24 coefficients inside its span costs rounding of at most their largest term,
    # pi^3 / 3! = 5.2 of the peak, 24 times 1.1e-16 each, on each side: 3e-14 of the sum of peaks (1e3 each).
    assert Profile.total(profiles)(time) == pytest.approx(expected, abs=1e-10)


def recentred(profile: Profile, time: float) -> list[float]:
    """Coefficients about a time, by synthetic division of floats."""
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
    # k * 1e-5 + 1e-5 and (k + 1) * 1e-5 are the same instant, and differ in the last bit for some k.
    parts = [Profile.half_sine(1.0, 1e-5, k * 1e-5) for k in range(3000)]
    total = Profile.total(parts)
    # Adding them one by one takes a hundred times as much for ten times as many.
    few, many = (count_calls(lambda count=count: Profile.total(parts[:count])) for count in (300, 3000))
    assert many < 15 * few
    assert len(total.starts) == 3001
    assert np.diff(total.starts).min() > 0.999e-5
    assert [total(t) for t in (0.5e-5, 0.01234567)] == pytest.approx([1.0, math.sin(0.567 * math.pi)], abs=1e-9)
    assert len(repr(total)) < 200 and total.description == "sum of 3000 profiles"
    twice = total + total
    assert twice.starts.tobytes() == total.starts.tobytes()
    assert twice.coefficients.tobytes() == (2.0 * total).coefficients.tobytes()


@pytest.mark.parametrize(("start", "told"), [(0.0, False), (-1e-9, False), (-0.02, True)])
def test_a_signal_that_begins_before_time_0_is_told_of(start: float, told: bool) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        Profile.table(np.arange(5) * H + start, [1.0, 2.0, 3.0, 2.0, 1.0]).compile(H, "left_force")
        Profile.constant(3.0, start=-1.0).compile(H)  # loses nothing
        (0.0 * Profile.triangle(1.0, 0.5, start=-0.2)).compile(H)
    assert [str(one.message).partition(":")[0] for one in caught] == (["left_force"] if told else [])
    assert not told or "2 of 5 breakpoints or samples lie before time 0" in str(caught[0].message)


def test_a_function_as_input_is_answered_with_how_to_sample_it() -> None:
    with pytest.raises(ParameterError, match=r"a number or a Profile; sample a function with Profile.table"):
        Oscillator().step(H, force=math.sin)


@given(shapes, st.floats(-100.0, 100.0), st.floats(0.0, 20.0))
def test_a_multiple_is_the_multiple(profile: Profile, factor: float, time: float) -> None:
    assert (factor * profile)(time) == pytest.approx(factor * profile(time), rel=1e-12, abs=1e-10)
    assert (profile * factor).coefficients.tobytes() == (factor * profile).coefficients.tobytes()


def test_profiles_describe_themselves() -> None:
    profile = Profile.constant(2.0) + Profile.triangle(1.0, 0.5)
    assert profile.description == "constant 2 + triangle of peak 1, 0.5 s"
    assert profile.to_dict()["starts"] == [0.0, 0.5]


def test_profiles_cannot_be_changed() -> None:
    profile = Profile.table([0.0, 1.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="read-only"):
        profile.coefficients[0, 0] = 3.0


def test_profiles_do_not_share_the_callers_arrays() -> None:
    times, values = np.array([0.0, 1.0]), np.array([1.0, 2.0])
    profile = Profile.table(times, values)
    times[0], values[0] = -5.0, 100.0
    assert profile(0.0) == 1.0


# -- on ticks ---------------------------------------------------------------------------------------------------------


@given(constants, st.integers(0, 1000))
def test_a_constant_compiles_to_itself(profile: Profile, tick: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        compiled = profile.compile(H)
    assert compiled.value(tick) == (profile.coefficients[0, 0] if tick >= compiled.ticks[0] else 0.0)


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
    for part in (0.0, 0.25, 0.5):
        expected = [profile((tick + part + 1e-13) * H) for tick in range(30)]
        # 1e-13 of a tick puts times on the right side of a breakpoint; slopes are at most 3 per 5 ticks.
        assert sampled(compiled, 30, part) == pytest.approx(expected, abs=ROUNDING)


def test_a_decimal_time_is_on_its_tick() -> None:
    """0.3 / 0.1 is 2.9999999999999996: still tick 3."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Profile.constant(1.0, start=0.3).compile(0.1).ticks.tolist() == [3]


def test_moved_breakpoints_warn_and_name_the_signal() -> None:
    profile = Profile.triangle(1.0, 10.4 * H)
    with pytest.warns(GranularWarning, match=r"left_force: 1 of 2 breakpoints.*0\.004 s.*step_size"):
        compiled = profile.compile(H, "left_force")
    assert compiled.ticks.tolist() == [0, 10]


def test_a_moved_piece_keeps_its_own_polynomial() -> None:
    """Only the instants where pieces begin move; between them the values are those of the profile."""
    profile = Profile.piecewise([0.0, 3.4 * H, 9.7 * H], [[1.0, 2.0], [5.0, -3.0, 40.0], [0.5]])
    with pytest.warns(GranularWarning):
        compiled = profile.compile(H)
    assert compiled.ticks.tolist() == [0, 3, 10]
    for tick in (0, 1, 2, 4, 5, 8, 9, 11):
        assert compiled.value(tick, 0.5) == pytest.approx(profile((tick + 0.5) * H), rel=ROUNDING)


def test_pieces_between_two_ticks_are_dropped_and_told() -> None:
    profile = Profile.table([0.0, 2.1 * H, 2.3 * H, 5 * H], [0.0, 1.0, 2.0, 3.0])
    with pytest.warns(GranularWarning, match="1 short pieces dropped"):
        compiled = profile.compile(H)
    assert compiled.ticks.tolist() == [0, 2, 5]


@pytest.mark.parametrize("profile", [Profile.triangle(5.0, 0.4 * H), Profile.half_sine(5.0, 0.3 * H, start=3 * H)])
def test_a_signal_that_would_vanish_is_refused(profile: Profile) -> None:
    with pytest.raises(ParameterError, match="vanish.*smaller step_size"):
        profile.compile(H)


@pytest.mark.parametrize("step_size", [0.0, -1.0, math.nan, math.inf, "1", None, [0.1]])
def test_wrong_step_sizes_are_refused(step_size: object) -> None:
    with pytest.raises(ParameterError, match="step_size"):
        Profile.constant(1.0).compile(step_size)  # type: ignore[arg-type]


def test_times_beyond_the_tick_range_are_refused() -> None:
    with pytest.raises(ParameterError, match="2\\^52"):
        Profile.table([0.0, 1e300], [0.0, 1.0]).compile(1e-6)


def test_compiling_twice_gives_the_same_object() -> None:
    profile = Profile.triangle(1.0, 0.5)
    assert profile.compile(H) is profile.compile(H)
    assert profile.compile(H) is not profile.compile(0.5 * H)


def test_equals_compares_bits() -> None:
    first, second = (Profile.triangle(1.0, 0.5).compile(H) for _ in range(2))
    assert first is not second and first.equals(second)
    assert not first.equals(Profile.triangle(1.0, 0.5).compile(0.5 * H))
    assert not first.equals(Profile.triangle(1.0 + 2**-52, 0.5).compile(H))
    assert not first.equals(Profile.triangle(1.0, 0.6).compile(H))
    assert not Profile.constant(0.0).compile(H).equals(Profile.constant(-0.0).compile(H))


def test_before_its_first_piece_a_compiled_profile_is_zero() -> None:
    compiled = Profile.constant(3.0, start=5 * H).compile(H)
    assert sampled(compiled, 7) == [0.0] * 5 + [3.0] * 2
    assert compiled.value(4, 0.999) == 0.0


@given(shapes)
def test_a_driven_component_feels_the_integral(profile: Profile) -> None:
    """A free body gains the momentum of the midpoint sum of its force: the profile is read inside the steps."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        compiled = profile.compile(H) if len(profile.starts) == 1 or profile.starts[-1] - profile.starts[0] > H else None
        if compiled is None:
            return
        body = Oscillator(mass=1.0, stiffness=0.0, step_size=H)
        body.step(200 * H, force=profile)
    expected = H * math.fsum(compiled.value(tick, 0.5) for tick in range(200))
    scale = H * math.fsum(abs(compiled.value(tick, 0.5)) for tick in range(200))
    # 200 additions, each rounded to 1.1e-16 of a partial sum that is at most the scale.
    assert body.get("velocity") == pytest.approx(expected, abs=200 * 1.2e-16 * scale + 1e-300)


# -- refusals ---------------------------------------------------------------------------------------------------------

NAN, HUGE = math.nan, 10**400


@pytest.mark.parametrize("bad", [NAN, math.inf, "3", None, HUGE, 1j, [1.0], {}, object()])
def test_wrong_numbers_name_their_argument(bad: object) -> None:
    for name, make in {
        "value": lambda: Profile.constant(bad),  # type: ignore[arg-type]
        "start": lambda: Profile.constant(1.0, start=bad),  # type: ignore[arg-type]
        "peak": lambda: Profile.triangle(bad, 1.0),  # type: ignore[arg-type]
        "duration": lambda: Profile.half_sine(1.0, bad),  # type: ignore[arg-type]
        "rise": lambda: Profile.triangle(1.0, 1.0, rise=bad),  # type: ignore[arg-type]
        "after": lambda: Profile.table([0.0, 1.0], [0.0, 1.0], after=bad),  # type: ignore[arg-type]
        "factor": lambda: Profile.constant(1.0) * (None if isinstance(bad, list) else bad),  # a list would be a pattern
    }.items():
        with pytest.raises(ParameterError, match=name):
            make()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Profile.triangle(1.0, 0.0), "duration: got 0, expected more than 0"),
        (lambda: Profile.triangle(1.0, 1.0, rise=2.0), "rise: got 2 s"),
        (lambda: Profile.triangle(1.0, 1.0, rise=-0.5), "rise: got -0.5 s"),
        (lambda: Profile.triangle(1.0, 1e-30, start=1.0), "duration: got 1e-30 s, too short"),
        (lambda: Profile.half_sine(1.0, 1e-20), "duration: got 1e-20 s"),
        (lambda: Profile.table([0.0], [1.0]), "times: got 1 sample"),
        (lambda: Profile.table([], []), "times: got an empty list"),
        (lambda: Profile.table([0.0, 1.0], [1.0]), "values: got 1 for 2 times"),
        (lambda: Profile.table([0.0, 2.0, 1.0], [1.0, 1.0, 1.0]), r"times\[2\]: 1 s follows 2 s"),
        (lambda: Profile.table([0.0, 0.0], [1.0, 1.0]), r"times\[1\]"),
        (lambda: Profile.table([0.0, NAN], [1.0, 1.0]), r"times\[1\]: got nan"),
        (lambda: Profile.table([0.0, 1.0], [1.0, math.inf]), r"values\[1\]: got inf"),
        (lambda: Profile.table([0.0, "x"], [1.0, 1.0]), r"times\[1\]: got"),
        (lambda: Profile.table([0.0, 1.0], [1.0, 1j]), "values: got .*a list of at least one number"),
        (lambda: Profile.table([0.0, HUGE], [1.0, 1.0]), "times: got"),
        (lambda: Profile.table([0.0, 1e-308], [0.0, 1e300]), r"coefficients\[0,1\]: got inf"),
        (lambda: Profile.piecewise([0.0], []), "coefficients: got 0 rows|coefficients: got"),
        (lambda: Profile.piecewise([0.0], [[1.0], [2.0]]), "coefficients: got 2 rows for 1 starts"),
        (lambda: Profile.piecewise([1.0, 0.0], [[1.0], [2.0]]), "starts: 0 s follows 1 s"),
        (lambda: Profile.piecewise([0.0], [[1.0] * 40]), "degree 39, at most 31"),
        (lambda: Profile.piecewise([0.0], ["a"]), "coefficients: got 'a'"),
        (lambda: Profile.piecewise([0.0], "a"), "coefficients: got 'a'"),
        (lambda: Profile.piecewise([0.0], 3), "coefficients: got 3"),
        (lambda: Profile.piecewise([0.0], [[[1.0]]]), "coefficients: got an array of shape"),
        (
            lambda: Profile(np.zeros(1), np.zeros((1, 1, 1))),
            r"coefficients: got an array of shape \(1, 1, 1\).*a row for each piece",
        ),
        (lambda: Profile(np.zeros(1), np.full((1, 2), NAN)), r"coefficients\[0,0\]: got nan"),
        (lambda: Profile.total([]), "profiles: got none"),
        (lambda: Profile.total(3), "profiles: got 3, expected a list of profiles"),
        (lambda: Profile.total([Profile.constant(1.0), 3.0]), r"profiles\[1\]: got 3.0"),
        (lambda: CompiledProfile(H, [0], [[1.0]]), "two arrays"),
        (lambda: CompiledProfile(H, np.array([0, 0]), np.zeros((2, 1))), "increasing ticks"),
    ],
)
def test_wrong_profiles_are_refused(make, words: str) -> None:  # noqa: ANN001
    with pytest.raises(ParameterError, match=words):
        make()


def test_adding_what_is_no_profile_is_a_type_error() -> None:
    with pytest.raises(TypeError):
        Profile.constant(1.0) + 3.0  # type: ignore[operator]
