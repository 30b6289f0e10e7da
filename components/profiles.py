"""Input signals in time.

A `Profile` is a piecewise polynomial of time, multiplied by a constant array for array inputs. It is zero before its first
piece, and its last piece never ends. Components integrate it with + and x only: the chain evaluates it at the stage times of
its integrator, other components use the mean over each tick. It is first compiled to the component's ticks: a tick with a
breakpoint inside, or of a curve above degree 3 that lasts fewer than 10 ticks, gets the mean of the signal over the tick, so
that the impulse is exact; all other ticks keep their polynomial.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .csv_history import read_history
from .errors import ParameterError, issue_warning, one_line
from .number_arrays import number_array
from .polynomials import mean_polynomials, polynomial_value, powers, shift_rows
from .support.float_arrays import FloatArray
from .support.validation import finite_number, positive_number

# Degree at which the Taylor series of sin(pi tau) on [0, 1] is truncated: pi^25 / 25! = 1.7e-13 of the peak.
_SINE_DEGREE = 23
_MAXIMUM_DEGREE = 31
# Times within this fraction of a tick count as equal to the tick, because decimal fractions of a second are rounded.
_SAME_TICK = 1e-9
# A curve above degree 3 with fewer ticks is not resolved: integrators would miss part of its impulse.
_RESOLVED = 10
# Two times whose difference is at most this fraction of the latest time are one instant, computed in two ways.
_SAME_INSTANT = 1e-13


@dataclass(frozen=True, eq=False)
class CompiledProfile:
    """A profile on the tick grid of one step size, in the form that kernels evaluate and logs store.

    Attributes:
        step_size: seconds per tick.
        ticks: first tick of each piece, increasing, shape (pieces,), int64.
        coefficients: shape (pieces, degree + 1); value = sum_k c_k s^k with s = ticks since the beginning of the piece.
        pattern: array of the input's shape that multiplies the polynomial; None for a scalar input.
    """

    step_size: float
    ticks: npt.NDArray[np.int64]
    coefficients: FloatArray
    pattern: FloatArray | None = None
    _known_means: dict[int, FloatArray] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        ticks, rows, pattern = self.ticks, self.coefficients, self.pattern
        sound = (
            ticks.ndim == 1
            and rows.ndim == 2
            and len(ticks) == len(rows) > 0
            and 1 <= rows.shape[1] <= _MAXIMUM_DEGREE + 1
            and not np.any(np.diff(ticks) <= 0)
            and np.isfinite(rows).all()
            and (pattern is None or np.isfinite(pattern).all())
        )
        if not sound:
            raise ParameterError(
                f"got ticks {one_line(ticks)}, coefficients {one_line(rows)} and the pattern {one_line(pattern)}",
                expected=f"increasing ticks (pieces,), finite numbers (pieces, degree + 1) up to degree {_MAXIMUM_DEGREE}",
                hint="give a Profile to step(), which compiles it",
                source="compiled profile",
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values."""
        return () if self.pattern is None else self.pattern.shape

    def polynomial_value(self, tick: int, part: float = 0.0) -> float:
        """Return the polynomial without `pattern`, `part` of a step after a tick; at a breakpoint that of the later piece."""
        piece = int(np.searchsorted(self.ticks, tick, side="right")) - 1
        return 0.0 if piece < 0 else polynomial_value(self.coefficients[piece], float(tick - self.ticks[piece]) + part)

    def value(self, tick: int, part: float = 0.0) -> Any:
        """Return the value `part` of a step after a tick [unit of the input]: a number, or an array of the input's shape."""
        factor = self.polynomial_value(tick, part)
        return factor if self.pattern is None else factor * self.pattern

    def mean(self, tick: int, part: int = 0, parts: int = 1) -> Any:
        """Return the mean over a tick, or over one of its equal parts [unit of the input]: a number, or an array."""
        piece = int(np.searchsorted(self.ticks, tick, side="right")) - 1
        middle = float(tick - self.ticks[piece]) + (part + 0.5) / parts
        factor = 0.0 if piece < 0 else polynomial_value(self._mean_coefficients(parts)[piece], middle)
        return factor if self.pattern is None else factor * self.pattern

    def mean_factors(self, tick: int, ticks: int) -> FloatArray:
        """Return the mean of the polynomial, without `pattern`, over each of `ticks` ticks from `tick` on, shape (ticks,)."""
        now = np.arange(tick, tick + ticks)
        piece = np.searchsorted(self.ticks, now, side="right") - 1
        rows, middle = self._mean_coefficients(1)[piece], (now - self.ticks[piece]) + 0.5
        value = np.zeros(ticks)
        for column in rows.T[::-1]:
            value = value * middle + column
        return np.where(piece < 0, 0.0, value)

    def _mean_coefficients(self, parts: int) -> FloatArray:
        """Return the coefficients of the mean over one of `parts` equal parts of a tick, a polynomial of its midpoint."""
        if parts not in self._known_means:
            self._known_means[parts] = mean_polynomials(self.coefficients, 1.0 / parts)
        return self._known_means[parts]

    def broadcast(self, shape: tuple[int, ...]) -> CompiledProfile:
        """Return the same signal for every element of an input of this shape; a profile of this shape is returned unchanged."""
        if self.shape == shape:
            return self
        if self.pattern is not None:
            raise ParameterError(
                f"got a profile of shape {self.shape}", expected=f"a profile of shape {shape}, or one for all elements"
            )
        return CompiledProfile(self.step_size, self.ticks, self.coefficients, np.ones(shape))


@dataclass(frozen=True, eq=False)
class Profile:
    """A piecewise polynomial of time.

    Attributes:
        starts: time at which each piece begins, increasing, shape (pieces,) [s].
        coefficients: shape (pieces, degree + 1); value = sum_k c_k (t - start)^k, in the unit of the input per s^k.
        description: text for users on the origin of the profile.
        pattern: array of the input's shape that multiplies the polynomial; `profile * array` sets it.
    """

    starts: FloatArray
    coefficients: FloatArray
    description: str = "piecewise polynomial"
    pattern: FloatArray | None = None
    _compiled: dict[float, CompiledProfile] = field(default_factory=dict, init=False, repr=False)

    # Make numpy use `__rmul__` for `array * profile`.
    __array_ufunc__ = None

    def __post_init__(self) -> None:
        starts, expected = _to_vector("starts", self.starts), "a row of numbers for each start"
        rows = np.atleast_2d(number_array("coefficients", self.coefficients, expected))
        if rows.ndim != 2 or len(rows) != len(starts):
            came = f"got an array of shape {rows.shape} for {len(starts)} starts"
            raise ParameterError(came, expected=expected, at="coefficients")
        if not 1 <= rows.shape[1] <= _MAXIMUM_DEGREE + 1:
            came = f"got degree {rows.shape[1] - 1}"
            raise ParameterError(came, expected=f"at most {_MAXIMUM_DEGREE}", at="coefficients")
        _refuse_decreasing_times("starts", starts)
        starts.setflags(write=False)
        rows.setflags(write=False)
        object.__setattr__(self, "starts", starts)
        object.__setattr__(self, "coefficients", rows)
        if self.pattern is not None:
            object.__setattr__(self, "pattern", _read_only_pattern(self.pattern))

    # -- ways to make one -------------------------------------------------------------------------------------------

    @staticmethod
    def constant(value: float, start: float = 0.0) -> Profile:
        """Return `value` from time `start` [s] on."""
        value, start = finite_number("value", value), finite_number("start", start)
        return Profile(np.array([start]), np.array([[value]]), f"constant {value:g}")

    @staticmethod
    def triangle(peak: float, duration: float, rise: float = 0.0, start: float = 0.0) -> Profile:
        """Return a rise from 0 to `peak` in `rise` [s], back to 0 at `duration` [s]; rise = 0 is the paper's triangle (3.3)."""
        peak, duration = finite_number("peak", peak), positive_number("duration", duration)
        rise, start = finite_number("rise", rise), finite_number("start", start)
        if not 0.0 <= rise <= duration:
            raise ParameterError(f"got {rise:g} s", expected=f"0 to the duration {duration:g} s", at="rise")
        starts, rows = [], []
        if start + rise > start:
            starts.append(start)
            rows.append([0.0, peak / rise])
        if start + rise < start + duration:
            starts.append(start + rise)
            rows.append([peak, -peak / (duration - rise)])
        if not starts:
            raise ParameterError(f"got {duration:g} s, less than the rounding error of the start, {start:g} s", at="duration")
        starts.append(start + duration)
        rows.append([0.0, 0.0])
        return Profile(np.array(starts), np.array(rows), f"triangle of peak {peak:g}, {duration:g} s")

    @staticmethod
    def half_sine(peak: float, duration: float, start: float = 0.0) -> Profile:
        """Return half a wave, peak sin(pi t / duration), as one polynomial of degree 23 (error 1.8e-13 of the peak)."""
        peak, duration, start = (
            finite_number("peak", peak),
            positive_number("duration", duration),
            finite_number("start", start),
        )
        row = np.zeros(_SINE_DEGREE + 1)
        rate, term = math.pi / duration, peak
        for power in range(1, _SINE_DEGREE + 1):
            term *= rate / power
            if power % 2:
                row[power] = term if power % 4 == 1 else -term
        if not np.isfinite(row).all():
            raise ParameterError(f"got {duration:g} s, too short for a half-sine in double precision", at="duration")
        rows = np.vstack([row, 0.0 * row])
        return Profile(np.array([start, start + duration]), rows, f"half-sine of peak {peak:g}, {duration:g} s")

    @staticmethod
    def table(times: npt.ArrayLike, values: npt.ArrayLike, after: float | str = 0.0) -> Profile:
        """Return the linear interpolation of samples.

        Args:
            times: increasing, shape (n,), n >= 2 [s].
            values: shape (n,), in the unit of the input.
            after: value after the last sample, or "hold" to keep the last sample.
        """
        instants, samples = _to_vector("times", times), _to_vector("values", values)
        if len(instants) != len(samples):
            raise ParameterError(f"got {len(samples)} values", expected=f"one for each of {len(instants)} times", at="values")
        if len(instants) < 2:
            raise ParameterError(f"got {len(instants)} sample", expected="at least 2", at="times")
        _refuse_decreasing_times("times", instants)
        if isinstance(after, str) and after != "hold":
            raise ParameterError(f"got {after!r}", expected='a number or "hold"', at="after")
        last = float(samples[-1]) if isinstance(after, str) else finite_number("after", after)
        rows = np.zeros((len(instants), 2))
        rows[:, 0] = samples
        with np.errstate(over="ignore"):  # infinite slopes are refused
            rows[:-1, 1] = np.diff(samples) / np.diff(instants)
        rows[-1, 0] = last
        return Profile(instants, rows, f"table of {len(instants)} samples")

    @staticmethod
    def from_csv(
        path: str | os.PathLike[str],
        *,
        offset_time: float = 0.0,
        after: float | str = 0.0,
        **reading: Any,
    ) -> Profile:
        """Return a measured history from a CSV file, interpolated linearly.

            push = ge.Profile.from_csv("hammer.csv", time_unit="us", value_unit="kN", unit="N")

        Samples before time 0 are ignored with a warning; `offset_time` shifts them.

        Args:
            path: the file, UTF-8; its header may contain the units, such as ``time [us],force [kN]``.
            offset_time: added to the times [s].
            after: value after the last sample, or "hold" to keep the last sample.
            **reading: columns, units, separators and scale; see `csv_history.read_history`.

        Raises:
            ParameterError: names the file, the line, the text found, and the expected text.
        """
        offset = finite_number("offset_time", offset_time)
        times, values = read_history(path, **reading)
        times = times + offset if offset else times
        if times[-1] < 0.0:
            raise ParameterError(f"every sample lies before time 0 (the last at {times[-1]:g} s)", at="offset_time")
        return Profile.table(times, values, after)

    @staticmethod
    def piecewise(starts: npt.ArrayLike, coefficients: npt.ArrayLike) -> Profile:
        """Return polynomials with explicit coefficients, in rows of any lengths: see the attributes of this class."""
        if not isinstance(coefficients, (Sequence, np.ndarray)) or isinstance(coefficients, str):
            expected = "one list of numbers for each piece"
            raise ParameterError(f"got {one_line(coefficients)}", expected=expected, at="coefficients")
        rows = [_to_vector("coefficients", row) for row in coefficients]
        padded = np.zeros((len(rows), max((len(row) for row in rows), default=1)))
        for row, target in zip(rows, padded, strict=True):
            target[: len(row)] = row
        return Profile(_to_vector("starts", starts), padded)

    @staticmethod
    def total(profiles: Iterable[Profile]) -> Profile:
        """Return the sum of profiles: the union of their breakpoints, with shifted and added polynomials.

        Breakpoints that differ by no more than the rounding of their times are merged.
        """
        given = profiles
        profiles = list(given) if isinstance(given, Iterable) else []
        if not profiles or not all(isinstance(profile, Profile) for profile in profiles):
            raise ParameterError(f"got {one_line(given)}", expected="a list of at least one Profile", at="profiles")
        if len(profiles) == 1:
            return profiles[0]
        pattern = profiles[0].pattern
        for place, profile in enumerate(profiles):
            if not np.array_equal(profile.pattern, pattern):  # type: ignore[arg-type] - None is equal to None alone
                hint = "add the scalar profiles first, then multiply the sum by an array"
                raise ParameterError("its pattern differs from that of the first profile", hint=hint, at=f"profiles[{place}]")
        times = np.unique(np.concatenate([profile.starts for profile in profiles]))
        new = np.append(True, np.diff(times) > _SAME_INSTANT * np.abs(times).max())
        # First and last time of each group of times that differ only by rounding.
        firsts, lasts = times[new], times[np.append(new[1:], True)]
        rows = np.zeros((len(firsts), max(profile.coefficients.shape[1] for profile in profiles)))
        with np.errstate(over="ignore", invalid="ignore"):  # non-finite numbers are refused
            for profile in profiles:
                profile._add_coefficients(rows, firsts, lasts)
        text = " + ".join(profile.description for profile in profiles[:4])
        return Profile(
            firsts, rows, text if len(profiles) < 4 and len(text) <= 100 else f"sum of {len(profiles)} profiles", pattern
        )

    # -- use --------------------------------------------------------------------------------------------------------

    def __call__(self, time: float) -> Any:
        """Return the value at a time [s], a number or an array; a breakpoint belongs to the piece that begins there."""
        time = finite_number("time", time) if type(time) is not float else time
        value = self._polynomial_value(time)
        return value if self.pattern is None else value * self.pattern

    def _polynomial_value(self, time: float) -> float:
        piece = int(np.searchsorted(self.starts, time, side="right")) - 1
        return 0.0 if piece < 0 else polynomial_value(self.coefficients[piece], time - float(self.starts[piece]))

    def __add__(self, other: Profile) -> Profile:
        """Return the sum of two profiles, computed by `total`."""
        return Profile.total([self, other]) if isinstance(other, Profile) else NotImplemented

    def __mul__(self, factor: Any) -> Profile:
        """Return the profile times a number, or times an array: one signal for each element of an array input."""
        if isinstance(factor, list | tuple) or np.ndim(factor):
            pattern = _read_only_pattern(factor)
            if self.pattern is not None and pattern.shape != self.pattern.shape:
                expected = f"a number, or the profile's shape {self.pattern.shape}"
                raise ParameterError(f"got shape {pattern.shape}", expected=expected, at="factor")
            pattern = pattern if self.pattern is None else _read_only_pattern(self.pattern * pattern)
            return Profile(self.starts, self.coefficients, f"({self.description}) x array {pattern.shape}", pattern)
        rows = self.coefficients * finite_number("factor", factor)
        return Profile(self.starts, rows, f"{factor:g} x ({self.description})", self.pattern)

    __rmul__ = __mul__

    def __repr__(self) -> str:
        first, last, pieces = self.starts[0], self.starts[-1], len(self.starts)
        return f"<Profile: {self.description}; {pieces} pieces, the first from {first:g} s, the last from {last:g} s>"

    def _add_coefficients(self, rows: FloatArray, firsts: FloatArray, lasts: FloatArray) -> None:
        """Add the polynomials of this profile, shifted, to the coefficients of a sum.

        Args:
            rows: coefficients of the sum, shape (breakpoints, degree + 1); updated.
            firsts: the sum's breakpoints, shape (breakpoints,) [s].
            lasts: last time of the group of times that each breakpoint represents, same shape [s].
        """
        # Add only the nonzero range: from the first piece, up to the last piece if that is zero.
        begin = int(np.searchsorted(lasts, self.starts[0]))
        silent = not self.coefficients[-1].any()
        end = int(np.searchsorted(lasts, self.starts[-1])) if silent else len(lasts)
        pieces = np.searchsorted(self.starts, lasts[begin:end], side="right") - 1
        # A piece that begins at this breakpoint keeps its coefficients unchanged.
        offsets = np.maximum(firsts[begin:end] - self.starts[pieces], 0.0)
        part = shift_rows(self.coefficients[pieces], offsets)
        rows[begin:end, : part.shape[1]] += part

    def compile(self, step_size: float, name: str = "profile") -> CompiledProfile:
        """Return the profile on a tick grid.

        A tick with a breakpoint inside, or of a curve above degree 3 that lasts fewer than 10 ticks, gets the mean of the
        signal over the tick, with a warning. The integral over any whole number of ticks is exact.

        Args:
            step_size: seconds per tick.
            name: name of the signal in messages.
        """
        step_size = positive_number("step_size", step_size)
        if step_size not in self._compiled:
            self._compiled[step_size] = self._compile(step_size, name)
        return self._compiled[step_size]

    def _compile(self, step_size: float, name: str) -> CompiledProfile:
        with np.errstate(over="ignore"):
            places = self.starts / step_size
        if np.abs(places).max() > 2.0**52:
            raise ParameterError(f"a breakpoint lies more than 2^52 steps of {step_size:g} s from the start", at=name)
        self._warn_about_early_samples(step_size, name)
        nearest = np.rint(places)
        # The quotient of two rounded times has an error of a few units in the last place.
        inside = np.abs(places - nearest) > np.maximum(_SAME_TICK, 4.0 * np.spacing(np.abs(places)))
        places = np.where(inside, places, nearest)
        short = self.coefficients[:, 4:].any(axis=1) & (np.diff(places, append=np.inf) < _RESOLVED)
        ticks_of_short = np.floor(places[short])[:, None] + np.arange(_RESOLVED)
        ends = np.append(places[1:], np.inf)[short, None]
        averaged = np.unique(np.concatenate([np.floor(places[inside]), ticks_of_short[ticks_of_short < ends]]))
        # Places of polynomial changes [ticks]: breakpoints, and both ends of each averaged tick. Row 0 is the zero before them.
        cuts = np.unique(np.concatenate([places, averaged, averaged + 1.0]))
        pieces = np.searchsorted(places, cuts, side="right")
        since = cuts - np.append(cuts[0], places)[pieces]
        lengths = np.diff(cuts, append=cuts[-1] + 1.0)
        within = np.isin(np.floor(cuts), averaged)
        with np.errstate(over="ignore", invalid="ignore"):  # infinite coefficients are refused
            scaled = self.coefficients * powers(step_size, self.coefficients.shape[1])
            rows = np.vstack([np.zeros(scaled.shape[1]), scaled])[pieces]
            rows = shift_rows(rows, np.where(within, since + 0.5 * lengths, since))
            integrals = mean_polynomials(rows[within], lengths[within])[:, 0] * lengths[within]
        first = ~within | (np.floor(cuts) == cuts)
        rows, ticks = rows[first], cuts[first]
        sums = np.bincount((np.cumsum(first) - 1)[within], integrals, len(ticks))
        rows[within[first]] = 0.0
        rows[within[first], 0] = sums[within[first]]
        if len(averaged):
            issue_warning(
                f"{name}: {int(inside.sum())} of {len(inside)} breakpoints or samples lie between ticks of {step_size:g} s, "
                f"and {int(short.sum())} curves last fewer than {_RESOLVED} ticks: {len(averaged)} ticks use the mean of the "
                "signal, which keeps its impulse; to resolve the signal, choose a smaller step_size that divides these times"
            )
        return CompiledProfile(step_size, ticks.astype(np.int64), rows, self.pattern)

    def _warn_about_early_samples(self, step_size: float, name: str) -> None:
        """Warn if the signal begins before time 0, where no run applies it."""
        early = int(np.searchsorted(self.starts, -_SAME_TICK * step_size))
        ends = np.append(self.starts[1:], np.inf)[:early]
        # A constant that extends beyond time 0 loses nothing.
        lost = self.coefficients[:early].any(axis=1) & ((ends <= 0.0) | self.coefficients[:early, 1:].any(axis=1))
        if lost.any():
            issue_warning(
                f"{name}: {early} of {len(self.starts)} breakpoints or samples lie before time 0 (the first at "
                f"{self.starts[0]:.6g} s) and are not used: the signal begins with {self._polynomial_value(0.0):.6g}; "
                f"to use all of it, add {-self.starts[0]:.6g} s to its times (offset_time, start)"
            )


def _refuse_decreasing_times(name: str, times: FloatArray) -> None:
    late = np.diff(times) <= 0
    if late.any():
        where = int(np.argmax(late)) + 1
        came = f"{times[where]:g} s follows {times[where - 1]:g} s"
        raise ParameterError(came, hint="times must increase", at=(name, where))


def _read_only_pattern(values: Any) -> FloatArray:
    expected = "an array of numbers, of the input's shape"
    pattern = number_array("pattern", values, expected)
    if not pattern.size or not pattern.ndim:
        raise ParameterError(f"got {one_line(values)}", expected=expected, at="pattern")
    pattern.setflags(write=False)
    return pattern


def _to_vector(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return at least one number as a vector; a single number becomes a vector of length one."""
    expected = "a list of at least one number"
    vector = np.atleast_1d(number_array(name, values, expected))
    if vector.ndim != 1 or not len(vector):
        raise ParameterError(f"got an array of shape {vector.shape}", expected=expected, at=name)
    return vector
