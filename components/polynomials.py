"""Polynomials with ascending coefficients: value, mean over an interval and shift of the origin, by + and x alone."""

from __future__ import annotations

import math

import numpy as np

from .support.float_arrays import FloatArray


def polynomial_value(coefficients: FloatArray, s: float) -> float:
    """Return sum_k c_k s^k, by Horner's rule."""
    value = 0.0
    for coefficient in coefficients[::-1]:
        value = value * s + float(coefficient)
    return value


@np.errstate(over="ignore", invalid="ignore")  # the component refuses non-finite values
def mean_polynomials(coefficients: FloatArray, width: float | FloatArray) -> FloatArray:
    """Return the means of polynomials over an interval, as polynomials of its midpoint.

    m_i = sum_j C(i + 2j, 2j) (width / 2)^2j / (2j + 1) c_(i + 2j): up to degree 1 the mean is the value at the midpoint.

    Args:
        coefficients: shape (pieces, degree + 1).
        width: width of the interval, one number for all pieces or shape (pieces,).
    """
    averages, power = coefficients.copy(), 1.0
    for order in range(2, coefficients.shape[1], 2):
        power = power * (0.25 * width * width)
        for index in range(coefficients.shape[1] - order):
            averages[:, index] += math.comb(index + order, order) / (order + 1) * power * coefficients[:, index + order]
    return averages


def powers(base: float, count: int) -> FloatArray:
    """Return base^0 to base^(count - 1), by repeated multiplication."""
    found = np.ones(count)
    for index in range(1, count):
        found[index] = found[index - 1] * base
    return found


def shift_rows(coefficients: FloatArray, offsets: FloatArray) -> FloatArray:
    """Return the coefficients of p(s + offset) for each row, by repeated synthetic division."""
    shifted = coefficients.copy()
    moved = np.flatnonzero((offsets != 0.0) & coefficients[:, 1:].any(axis=1))
    # One row per power, so that numpy traverses contiguous memory.
    powers, by = np.ascontiguousarray(coefficients[moved].T), offsets[moved]
    for first in range(len(powers) - 1):
        for index in range(len(powers) - 2, first - 1, -1):
            powers[index] += by * powers[index + 1]
    shifted[moved] = powers.T
    return shifted
