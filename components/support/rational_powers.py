"""Rational powers by + x / and sqrt alone, x^(2/3), x^(1/5), x^(1/n), x^n: the same bits on every machine, where pow is not."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_MOST_STEPS = 200


def two_thirds_power(value: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """value^(2/3) for an array of numbers >= 0, by Newton's iteration on y sqrt(y) = value."""
    # y^1.5 is convex and 1 + value lies above the root, so the iteration comes down on it from one side.
    root = np.where(value > 0.0, 1.0 + value, 0.0)
    before = root
    for left in range(_MOST_STEPS, 0, -1):
        slope = np.sqrt(root)
        better = np.where(root > 0.0, root - (root * slope - value) / np.where(slope > 0.0, 1.5 * slope, 1.0), 0.0)
        better = np.maximum(better, 0.0)
        if np.all(np.abs(better - root) <= 1e-16 * root):
            break
        if np.array_equal(better, before):  # two neighbours in turn: what comes last is known
            root = root if left % 2 == 0 else better
            break
        before, root = root, better
    return np.where(value > 0.0, root, 0.0)


def fifth_root(value: float) -> float:
    """value^(1/5) for a finite number > 0, by Newton's iteration."""
    if not 0.0 < value < float("inf"):
        raise ValueError(f"fifth_root of {value}")
    scale = 1.0
    while value > 32.0:
        value, scale = value / 32.0, scale * 2.0
    while value < 1.0:
        value, scale = value * 32.0, scale * 0.5
    root = 2.0
    for _ in range(60):
        fourth = root * root * root * root
        better = root - (root * fourth - value) / (5.0 * fourth)
        if better >= root:
            break
        root = better
    return root * scale


def nth_root(value: float, degree: int) -> float:
    """value^(1/degree) for a finite number > 0 and a degree from 1, by halving the interval until no float is left in it."""
    if not (0.0 < value < float("inf") and degree >= 1):
        raise ValueError(f"root of degree {degree} of {value}")
    low, high = min(1.0, value), max(1.0, value)
    while True:
        middle = low + 0.5 * (high - low)
        if not low < middle < high:
            return high
        low, high = (middle, high) if integer_power(middle, degree) < value else (low, middle)


def integer_power(base: float, exponent: int) -> float:
    """base^exponent for an exponent from 0, by squaring: about 2 log2(exponent) multiplications."""
    result = 1.0
    while exponent:
        result = result * base if exponent & 1 else result
        base, exponent = base * base, exponent >> 1
    return result
