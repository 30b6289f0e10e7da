"""x^p and e^x from + - x / and bit operations alone: identical results on every machine, unlike the C library's."""

from __future__ import annotations

import numpy as np

from .jit import inlined, internal_inlined

_LN2 = 0.6931471805599453
_TWO_OVER_LN2 = 2.8853900817779268
_ROOT_2 = 1.4142135623730951
# ln 2 in two parts: the first has few bits, so that its product with a small whole number is exact.
_LN2_HIGH, _LN2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
# Outside these limits of x, e^x is not a normal floating-point number.
_SMALLEST, _LARGEST = -708.0, 709.0
# Adding and subtracting 1.5 x 2^52 rounds to a whole number.
_ROUNDING = 6755399441055744.0
_FRACTION, _ONE_BITS, _EXPONENT_BIAS = np.int64(0x000FFFFFFFFFFFFF), np.int64(0x3FF0000000000000), np.int64(1023)
_FRACTION_WIDTH = np.int64(52)
# Mask of the upper 26 bits of a number: their product with an exponent is exact.
_UPPER_BITS = np.int64(-(1 << 27))


@inlined
def power(x, p):
    """Return x^p for a normal float x > 0 and 0 <= p <= 100, to about a unit in the last place; 0 for a subnormal result."""
    bits = np.float64(x).view(np.int64)
    exponent = np.float64((bits >> _FRACTION_WIDTH) - _EXPONENT_BIAS)
    fraction = np.int64((bits & _FRACTION) | _ONE_BITS).view(np.float64)
    large = fraction > _ROOT_2
    fraction = 0.5 * fraction if large else fraction
    exponent = exponent + 1.0 if large else exponent
    logarithm = _logarithm(fraction)
    upper = np.int64(np.float64(p).view(np.int64) & _UPPER_BITS).view(np.float64)
    whole = ((p * exponent + p * logarithm) + _ROUNDING) - _ROUNDING
    rest = (upper * exponent - whole) + ((p - upper) * exponent + p * logarithm)
    inside = -1022.0 if whole < -1022.0 else (1023.0 if whole > 1023.0 else whole)
    scale = np.int64((np.int64(inside) + _EXPONENT_BIAS) << _FRACTION_WIDTH).view(np.float64)
    result = scale * _exponential(rest * _LN2)
    return 0.0 if whole < -1022.0 else (np.inf if whole > 1023.0 else result)


@inlined
def exponential(x):
    """Return e^x to about one unit in the last place; 0 below x = -708, infinite above 709."""
    inside = _SMALLEST if x < _SMALLEST else (_LARGEST if x > _LARGEST else x)
    whole = (0.5 * _TWO_OVER_LN2 * inside + _ROUNDING) - _ROUNDING
    rest = (inside - whole * _LN2_HIGH) - whole * _LN2_LOW
    scale = np.int64((np.int64(whole) + _EXPONENT_BIAS) << _FRACTION_WIDTH).view(np.float64)
    result = scale * _exponential(rest)
    return 0.0 if x < _SMALLEST else (np.inf if x > _LARGEST else result)


@internal_inlined
def _logarithm(fraction):
    """Return log2(fraction) for sqrt(1/2) < fraction <= sqrt(2), by the series of artanh."""
    s = (fraction - 1.0) / (fraction + 1.0)
    q = s * s
    series = 1.0 / 23.0
    series = series * q + 1.0 / 21.0
    series = series * q + 1.0 / 19.0
    series = series * q + 1.0 / 17.0
    series = series * q + 1.0 / 15.0
    series = series * q + 1.0 / 13.0
    series = series * q + 1.0 / 11.0
    series = series * q + 1.0 / 9.0
    series = series * q + 1.0 / 7.0
    series = series * q + 1.0 / 5.0
    series = series * q + 1.0 / 3.0
    return _TWO_OVER_LN2 * (s + s * (q * series))


@internal_inlined
def _exponential(z):
    """Return e^z for |z| <= 0.35, by its Taylor series."""
    series = 1.0 / 6227020800.0
    series = series * z + 1.0 / 479001600.0
    series = series * z + 1.0 / 39916800.0
    series = series * z + 1.0 / 3628800.0
    series = series * z + 1.0 / 362880.0
    series = series * z + 1.0 / 40320.0
    series = series * z + 1.0 / 5040.0
    series = series * z + 1.0 / 720.0
    series = series * z + 1.0 / 120.0
    series = series * z + 1.0 / 24.0
    series = series * z + 1.0 / 6.0
    series = series * z + 0.5
    return 1.0 + (z + (z * z) * series)
