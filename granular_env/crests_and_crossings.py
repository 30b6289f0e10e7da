"""Crests (height, time, width) and level crossings of sampled curves, interpolated between samples."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import positive_number

# Number of samples through which the interpolating polynomial passes.
SAMPLES = 7


@dataclasses.dataclass(frozen=True, slots=True)
class Crest:
    """A maximum of a curve.

    Attributes:
        time: time of the maximum.
        height: value of the maximum.
        begin: time of the minimum before the crest, or of the last sample at or below 0 before it.
        end: time of the minimum after the crest, or of the first sample at or below 0 after it.
        duration: time for which the curve exceeds half the height; NaN if it does not fall below half on both sides.
    """

    time: float
    height: float
    begin: float
    end: float
    duration: float


def crests(times: Any, values: Any, above: float, separation: float = 1.0) -> list[Crest]:
    """Return the maxima of a sampled curve, in the order of time.

    Times and heights come from the polynomial of degree 6 through the seven nearest samples. A maximum at the first or last
    sample of the curve does not count.

    Args:
        times: shape (T,), increasing.
        values: shape (T,).
        above: threshold that a crest exceeds, in the unit of the values, greater than 0.
        separation: a crest is separate if the curve falls below this fraction of its height on both sides before it
            rises higher; 1 counts every maximum.

    Raises:
        ParameterError: mismatched shapes, values that are not finite, times that do not increase,
            a threshold that is not positive, or a separation outside (0, 1].
    """
    times, values = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if times.ndim != 1 or times.shape != values.shape or not len(times):
        raise ParameterError(
            f"got times {times.shape} and values {values.shape}", expected="two non-empty arrays (T,)", at="crests"
        )
    for name, array in (("times", times), ("values", values)):
        if not np.isfinite(array).all():
            raise ParameterError(f"contains {array[~np.isfinite(array)][0]:g}", expected="finite numbers", at=name)
    if (np.diff(times) <= 0.0).any():
        raise ParameterError("not increasing", hint="sort the samples, or pass a single run without a reset", at="times")
    return [
        Crest(
            *interpolated_maximum(times, values, peak),
            float(times[begin]),
            float(times[end]),
            _half_height_duration(times, values, begin, peak, end),
        )
        for begin, peak, end in crest_indices(values, above, separation)
    ]


def crest_indices(values: FloatArray, above: float, separation: float) -> list[tuple[int, int, int]]:
    """Return three sample indices per maximum: its begin (minimum or last value at or below 0 before it), its top, its end."""
    from scipy.signal import find_peaks

    above, separation = positive_number("above", above), positive_number("separation", separation)
    if separation > 1.0:
        raise ParameterError(f"got {separation:g}", expected="more than 0 and at most 1", at="separation")
    peaks, _ = find_peaks(values, prominence=(1.0 - separation) * np.maximum(values, 0.0))
    walls = [0, *peaks.tolist(), len(values) - 1]
    return [
        (_foot_before(values, walls[i - 1], peak), peak, _foot_after(values, peak, walls[i + 1]))
        for i, peak in enumerate(walls[1:-1], start=1)
        if values[peak] > above
    ]


def _foot_before(values: FloatArray, first: int, peak: int) -> int:
    return peak - _foot_after(values[first : peak + 1][::-1], 0, peak - first)


def _foot_after(values: FloatArray, peak: int, last: int) -> int:
    """Return the sample index of a maximum's end: the first value at or below 0, else the smallest before the next maximum."""
    down = values[peak : last + 1] <= 0.0
    return peak + int(np.argmax(down) if down.any() else np.argmin(values[peak : last + 1]))


def interpolated_maximum(times: FloatArray, values: FloatArray, peak: int) -> tuple[float, float]:
    """Return time and height of the curve's maximum near the sample `peak`, from the polynomial through its neighbours."""
    curve, time = _local_polynomial(times, values, peak), float(times[peak])
    low, high = (float(times[min(max(i, 0), len(times) - 1)]) - time for i in (peak - 1, peak + 1))
    place = _bracketed_root(lambda x: curve.value_and_slope(x)[1], low, high)
    height = curve.value_and_slope(place)[0] if place is not None else -math.inf
    if place is None or not height > values[peak]:
        return time, float(values[peak])
    return time + place, height


def resolved_maximum(times: FloatArray, values: FloatArray, peak: int) -> tuple[float, float] | None:
    """Return time and height of the curve's maximum near the sample `peak`, or None if the samples do not resolve it.

    A maximum is resolved if the curve is concave at the sample and at both neighbours. Jumps, plateaus, pulses of two or three
    samples, and maxima at the end of the curve are not resolved: a polynomial would invent values between these samples.
    """
    if not 2 <= peak < len(values) - 2:
        return None
    own = slice(peak - 2, peak + 3)
    slopes = np.diff(values[own]) / np.diff(times[own])
    if (np.diff(slopes) > 0.0).any() or not slopes[1] > 0.0 > slopes[2]:
        return None
    return interpolated_maximum(times, values, peak)


def crossing_time(times: FloatArray, values: FloatArray, sample: int, level: float) -> float:
    """Return the time at which the curve crosses `level` between `sample` and the next sample, which lie on opposite sides."""
    curve, length = _local_polynomial(times, values, sample), float(times[sample + 1] - times[sample])
    place = _bracketed_root(lambda x: curve.value_and_slope(x)[0] - level, 0.0, length)
    if place is None:
        place = length * (level - float(values[sample])) / float(values[sample + 1] - values[sample])
    return float(times[sample]) + place


class _Polynomial(NamedTuple):
    """A polynomial in Newton's form, c0 + (x - x0) (c1 + (x - x1) (c2 + ...)), bitwise equal on every processor."""

    nodes: list[float]
    coefficients: list[float]

    def value_and_slope(self, x: float) -> tuple[float, float]:
        """Return the polynomial's value and derivative at x."""
        value, slope = self.coefficients[-1], 0.0
        for node, coefficient in zip(self.nodes[-2::-1], self.coefficients[-2::-1], strict=True):
            slope = slope * (x - node) + value
            value = value * (x - node) + coefficient
        return value, slope


def _local_polynomial(times: FloatArray, values: FloatArray, sample: int) -> _Polynomial:
    """Return the polynomial through the samples nearest to `sample`; its variable is the time since this sample [s]."""
    first = min(max(sample - SAMPLES // 2, 0), max(len(times) - SAMPLES, 0))
    nodes, differences = times[first : first + SAMPLES] - times[sample], values[first : first + SAMPLES].copy()
    for order in range(1, len(nodes)):
        differences[order:] = np.diff(differences[order - 1 :]) / (nodes[order:] - nodes[:-order])
    return _Polynomial(nodes.tolist(), differences.tolist())


def _bracketed_root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """Return the zero of a function between low and high, or None if the function has the same sign at both."""
    from scipy.optimize import brentq

    if not function(low) * function(high) <= 0.0 or low == high:
        return None
    found: Any = brentq(function, low, high, xtol=1e-12 * (high - low))
    return float(found)


def _half_height_duration(times: FloatArray, values: FloatArray, begin: int, peak: int, end: int) -> float:
    half = 0.5 * interpolated_maximum(times, values, peak)[1]
    rise, fall = values[begin : peak + 1] <= half, values[peak : end + 1] <= half
    if not (rise.any() and fall.any()):
        return float("nan")
    before, after = begin + int(np.flatnonzero(rise)[-1]), peak + int(np.argmax(fall)) - 1
    return crossing_time(times, values, after, half) - crossing_time(times, values, before, half)
