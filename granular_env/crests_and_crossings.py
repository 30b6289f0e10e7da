"""Crests of sampled curves (how high, when, how wide), and when a curve crosses a level, between the samples."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from granular_env.components.support.float_arrays import FloatArray

from .components.errors import ParameterError, one_line

# A polynomial through so many samples says what lies between them.
SAMPLES = 7


@dataclasses.dataclass(frozen=True, slots=True)
class Crest:
    """A maximum of a curve.

    Attributes:
        time: when it is reached.
        height: how high it is.
        begin: time of the minimum before it, or of the last sample at or below 0.
        end: time of the minimum after it, or of the first sample at or below 0.
        duration: how long the curve is above half the height; NaN where it does not fall so far on both sides.
    """

    time: float
    height: float
    begin: float
    end: float
    duration: float


def crests(times: Any, values: Any, above: float, separation: float = 1.0) -> list[Crest]:
    """Return the maxima of a sampled curve, in the order of time.

    Times and heights are read off the polynomial of degree 6 through the seven nearest samples. A maximum at the curve's very
    first or last sample is none.

    Args:
        times: shape (T,), increasing.
        values: shape (T,).
        above: height that a crest exceeds, in the unit of the values, more than 0.
        separation: a crest is one of its own where the curve falls below this part of its height on both sides before it
            rises any higher; 1 counts every maximum.

    Raises:
        ParameterError: shapes that do not fit, values that are not finite, times that do not increase,
            a threshold that is not positive, a separation outside of (0, 1].
    """
    times, values = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if times.ndim != 1 or times.shape != values.shape or not len(times):
        raise ParameterError(
            f"got times {times.shape} and values {values.shape}", expected="two equal, non-empty (T,)", at="crests"
        )
    for name, array in (("times", times), ("values", values)):
        if not np.isfinite(array).all():
            raise ParameterError(f"got {array[~np.isfinite(array)][0]:g} among them", expected="finite numbers", at=name)
    if (np.diff(times) <= 0.0).any():
        raise ParameterError("they do not increase", hint="sort them, or give one run without a reset within it", at="times")
    return [
        Crest(*top(times, values, peak), float(times[begin]), float(times[end]), _duration(times, values, begin, peak, end))
        for begin, peak, end in ridges(values, above, separation)
    ]


def ridges(values: FloatArray, above: float, separation: float) -> list[tuple[int, int, int]]:
    """Each maximum as samples: the minimum before it (or the last value at or below 0), itself, the minimum after it."""
    from scipy.signal import find_peaks

    above, separation = positive("above", above, "in the unit of the curve"), fraction("separation", separation)
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
    """Return where a maximum ends: at the first value at or below 0, or the least one before the next maximum."""
    down = values[peak : last + 1] <= 0.0
    return peak + int(np.argmax(down) if down.any() else np.argmin(values[peak : last + 1]))


def top(times: FloatArray, values: FloatArray, peak: int) -> tuple[float, float]:
    """Time and height of the maximum next to a sample."""
    curve, scale = _curve(times, values, peak)
    found = [float(root.real) for root in curve.deriv().roots() if abs(root.imag) < 1e-6]
    low, high = ((times[min(max(i, 0), len(times) - 1)] - times[peak]) / scale for i in (peak - 1, peak + 1))
    place = max((x for x in found if low <= x <= high), key=lambda x: float(curve(x)), default=0.0)
    height = float(curve(place))
    if not height > values[peak]:
        return float(times[peak]), float(values[peak])
    return float(times[peak] + place * scale), height


def resolved_top(times: FloatArray, values: FloatArray, peak: int) -> tuple[float, float] | None:
    """Return the time and the height of the maximum next to a sample; None where the samples do not resolve it.

    They do where the curve is concave at the sample and at both its neighbours. A jump, a plateau, a pulse of two or three
    samples, and a maximum at the curve's very end are not resolved: a polynomial would make up what lies between such samples.
    """
    if not 2 <= peak < len(values) - 2:
        return None
    own = slice(peak - 2, peak + 3)
    slopes = np.diff(values[own]) / np.diff(times[own])
    if (np.diff(slopes) > 0.0).any() or not slopes[1] > 0.0 > slopes[2]:
        return None
    return top(times, values, peak)


def crossing(times: FloatArray, values: FloatArray, after: int, level: float) -> float:
    """Return when the curve passes a level between a sample and the next one; the two lie on different sides of it."""
    curve, scale = _curve(times, values, after)
    length = (times[after + 1] - times[after]) / scale
    found = [float(root.real) for root in (curve - level).roots() if abs(root.imag) < 1e-9 and 0.0 <= root.real <= length]
    if len(found) != 1:  # a curve with a kink
        found = [length * (level - values[after]) / (values[after + 1] - values[after])]
    return float(times[after] + found[0] * scale)


def _curve(times: FloatArray, values: FloatArray, near: int) -> tuple[Polynomial, float]:
    """Return the polynomial through the samples nearest to one of them, in (time - its time) / scale, and the scale."""
    first = min(max(near - SAMPLES // 2, 0), max(len(times) - SAMPLES, 0))
    own = slice(first, first + SAMPLES)
    scale = float(times[own][-1] - times[own][0]) or 1.0
    curve = Polynomial.fit((times[own] - times[near]) / scale, values[own], len(times[own]) - 1)
    return curve.convert(), scale


def _duration(times: FloatArray, values: FloatArray, begin: int, peak: int, end: int) -> float:
    half = 0.5 * top(times, values, peak)[1]
    rise, fall = values[begin : peak + 1] <= half, values[peak : end + 1] <= half
    if not (rise.any() and fall.any()):
        return float("nan")
    before, after = begin + int(np.flatnonzero(rise)[-1]), peak + int(np.argmax(fall)) - 1
    return crossing(times, values, after, half) - crossing(times, values, before, half)


def positive(name: str, value: Any, unit: str) -> float:
    """Return a value that is a finite number above 0, or raise."""
    number = value if isinstance(value, (int, float, np.number)) and not isinstance(value, bool) else math.nan
    if not (0.0 < number < math.inf):
        raise ParameterError(f"got {one_line(value)}", expected=f"more than 0 {unit}".rstrip(), at=name)
    return float(number)


def fraction(name: str, value: Any) -> float:
    """Return a value that is above 0 and at most 1, or raise."""
    number = positive(name, value, "and at most 1")
    if number > 1.0:
        raise ParameterError(f"got {number:g}", expected="more than 0 and at most 1", at=name)
    return number
