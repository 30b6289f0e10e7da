"""Elementary functions, rational powers, a Fourier transform and a spline from + - x / and sqrt alone: bitwise reproducible.

numpy and the C library select versions of exp, log, sin and pow by CPU, and their last bits differ. Constants of components
and environments use the functions here. In compiled loops use `powers.power` for x^p.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from .float_arrays import FloatArray

# ln 2 in two parts: the first has few bits, so that its product with a small whole number is exact.
_LN2_HIGH, _LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
_NEWTON_STEPS, _MOST_STEPS = 60, 200


def exponential(x: npt.ArrayLike) -> FloatArray:
    """Return e^x for |x| <= 700, correct to a few units in the last place."""
    given = np.asarray(x, dtype=np.float64)
    twos = np.rint(given / (_LN2_HIGH + _LN2_LOW))
    rest = (given - twos * _LN2_HIGH) - twos * _LN2_LOW
    return np.ldexp(_series(rest, [1.0 / math.factorial(k) for k in range(15)]), twos.astype(np.int32))


def logarithm(x: npt.ArrayLike) -> FloatArray:
    """Return ln x for x > 0, correct to a few units in the last place."""
    fraction, twos = np.frexp(np.asarray(x, dtype=np.float64))
    small = fraction < math.sqrt(0.5)
    fraction, twos = np.where(small, 2.0 * fraction, fraction), np.where(small, twos - 1, twos)
    s = (fraction - 1.0) / (fraction + 1.0)
    tail = 2.0 * s * _series(s * s, [1.0 / (2 * k + 1) for k in range(12)])
    return twos * _LN2_HIGH + (twos * _LN2_LOW + tail)


def root(x: npt.ArrayLike, degree: int) -> FloatArray:
    """Return x^(1/degree) for x > 0, correct to a few units in the last place."""
    fraction, twos = np.frexp(np.asarray(x, dtype=np.float64))
    whole, left = np.divmod(twos, degree)
    inside = np.ldexp(fraction, left)
    found = np.full(inside.shape, 2.0)
    for _ in range(_NEWTON_STEPS):  # from above: decreasing until rounding stops it
        found = found - (found - inside / _power(found, degree - 1)) / degree
    return np.ldexp(found, whole)


def sine_of_pi(x: npt.ArrayLike) -> FloatArray:
    """Return sin(pi x) with an absolute error of a few times 2.2e-16, the spacing of floats at 1."""
    given = np.asarray(x, dtype=np.float64)
    nearest = np.rint(2.0 * given)
    angle = math.pi * (given - 0.5 * nearest)  # within an eighth of a turn
    square = angle * angle
    sine = angle * _series(square, [(-1) ** k / math.factorial(2 * k + 1) for k in range(10)])
    cosine = _series(square, [(-1) ** k / math.factorial(2 * k) for k in range(11)])
    quarter = nearest.astype(np.int64) % 4
    return np.choose(quarter, [sine, cosine, -sine, -cosine])


def fourier(real: FloatArray, imaginary: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the discrete Fourier transform sum_j z_j exp(-2 pi i j k / n) of n numbers, n a power of 2, as two arrays.

    The transform of a real even sequence is real and even: two such sequences fit into one call, as real and imaginary part.
    """
    re, im = real.reshape(-1, 1).copy(), imaginary.reshape(-1, 1).copy()
    for cosine, sine in _twiddle_factors(len(real)):
        # Stockham's order: no bit reversal, and every sum has two terms.
        half = len(re) // 2
        first_re, first_im, second_re, second_im = re[:half], im[:half], re[half:], im[half:]
        less_re, less_im = first_re - second_re, first_im - second_im
        turned_re, turned_im = less_re * cosine - less_im * sine, less_re * sine + less_im * cosine
        re = np.concatenate((first_re + second_re, turned_re), axis=1)
        im = np.concatenate((first_im + second_im, turned_im), axis=1)
    return re.reshape(-1), im.reshape(-1)


@lru_cache(maxsize=8)
def _twiddle_factors(count: int) -> list[tuple[FloatArray, FloatArray]]:
    """Return cosine and sine of -2 pi k / length for each stage, shape (length / 2, 1)."""
    stages, length = [], count
    while length > 1:
        turns = np.arange(length // 2)[:, None] / length
        stages.append((sine_of_pi(0.5 - 2.0 * turns), sine_of_pi(-2.0 * turns)))
        length //= 2
    return stages


def natural_spline(values: FloatArray, refinement: int) -> FloatArray:
    """Return the natural cubic spline through equidistant values, at every 1/refinement of their spacing.

    Args:
        values: shape (n,).
        refinement: points per interval.

    Returns:
        Shape ((n - 1) refinement + 1,).
    """
    curvature = _spline_curvatures(values.tolist())
    t = np.arange(refinement) / refinement
    pieces = []
    for (a, b), (p, q) in zip(pairwise(values.tolist()), pairwise(curvature), strict=True):
        s = 1.0 - t
        pieces.append(s * a + t * b + ((s * s * s - s) * p + (t * t * t - t) * q) / 6.0)
    return np.concatenate([*pieces, values[-1:]])


def _spline_curvatures(values: list[float]) -> list[float]:
    """Return second derivatives of the spline: p_(k-1) + 4 p_k + p_(k+1) = 6 (v_(k-1) - 2 v_k + v_(k+1)), 0 at the ends."""
    pivots, sides = [], []
    for before, here, after in zip(values, values[1:], values[2:], strict=False):
        pivot, side = 4.0, 6.0 * (before - 2.0 * here + after)
        if pivots:
            pivot, side = 4.0 - 1.0 / pivots[-1], side - sides[-1] / pivots[-1]
        pivots.append(pivot)
        sides.append(side)
    found = [0.0]
    for pivot, side in zip(reversed(pivots), reversed(sides), strict=True):
        found.append((side - found[-1]) / pivot)
    return [0.0, *reversed(found)]


def _series(x: FloatArray, coefficients: list[float]) -> FloatArray:
    """Return c_0 + c_1 x + ..., by Horner's rule."""
    result = np.full(x.shape, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        result = result * x + coefficient
    return result


def _power(x: FloatArray, exponent: int) -> FloatArray:
    result = np.ones(x.shape)
    for _ in range(exponent):
        result = result * x
    return result


def two_thirds_power(value: FloatArray) -> FloatArray:
    """Return value^(2/3) for an array of numbers >= 0, by Newton's iteration on y sqrt(y) = value."""
    # y^1.5 is convex and 1 + value lies above the root, so the iteration decreases monotonically.
    root = np.where(value > 0.0, 1.0 + value, 0.0)
    before = root
    for left in range(_MOST_STEPS, 0, -1):
        slope = np.sqrt(root)
        better = np.where(root > 0.0, root - (root * slope - value) / np.where(slope > 0.0, 1.5 * slope, 1.0), 0.0)
        better = np.maximum(better, 0.0)
        if np.all(np.abs(better - root) <= 1e-16 * root):
            break
        if np.array_equal(better, before):  # alternates between two adjacent floats
            root = root if left % 2 == 0 else better
            break
        before, root = root, better
    return np.where(value > 0.0, root, 0.0)


def nth_root(value: float, degree: int) -> float:
    """Return value^(1/degree) for a finite number > 0 and a degree >= 1, by bisection down to two adjacent floats."""
    if not (0.0 < value < float("inf") and degree >= 1):
        raise ValueError(f"root of degree {degree} of {value}")
    low, high = min(1.0, value), max(1.0, value)
    while True:
        middle = low + 0.5 * (high - low)
        if not low < middle < high:
            return high
        low, high = (middle, high) if integer_power(middle, degree) < value else (low, middle)


def integer_power(base: float, exponent: int) -> float:
    """Return base^exponent for an exponent >= 0, by squaring: about 2 log2(exponent) multiplications."""
    result = 1.0
    while exponent:
        result = result * base if exponent & 1 else result
        base, exponent = base * base, exponent >> 1
    return result
