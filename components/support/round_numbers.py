"""Rounding to 1, 2 or 5 x 10^k, down or up."""

from __future__ import annotations


def round_down_to_125(value: float) -> float:
    """Return the largest of 1, 2, 5 x 10^k that is at most `value` > 0, so that typical durations are multiples of it."""
    return max(candidate for candidate in _candidates_125(value) if candidate <= value)


def round_up_to_125(value: float) -> float:
    """Return the smallest of 1, 2, 5 x 10^k that is at least `value` > 0."""
    return min(candidate for candidate in _candidates_125(value) if candidate >= value)


def _candidates_125(value: float) -> list[float]:
    exponent = int(f"{value:e}".split("e")[1])
    return [float(f"{digit}e{power}") for power in (exponent - 1, exponent, exponent + 1) for digit in (1, 2, 5)]
