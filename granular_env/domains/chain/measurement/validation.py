"""Refusals that the measurements share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from granular_env.components.errors import ParameterError, shortened


def whole_number(name: str, value: Any, least: int, most: int) -> int:
    """A whole number within bounds."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        raise ParameterError(f"{name}: got {shortened(value)}, expected a whole number from {least} to {most}")
    return int(value)


def positive(name: str, value: Any, unit: str) -> float:
    """A finite number above 0."""
    number = value if isinstance(value, (int, float, np.number)) and not isinstance(value, bool) else math.nan
    if not (0.0 < number < math.inf):
        raise ParameterError(f"{name}: got {shortened(value)}, expected more than 0 {unit}".rstrip())
    return float(number)


def fraction(name: str, value: Any) -> float:
    """A number above 0 and at most 1."""
    number = positive(name, value, "and at most 1")
    if number > 1.0:
        raise ParameterError(f"{name}: got {number:g}, expected more than 0 and at most 1")
    return number


def sign(direction: Any) -> float:
    """+1 for what runs to the right, -1 to the left."""
    if direction not in ("right", "left"):
        raise ParameterError(f"direction: got {shortened(direction)}, expected 'right' or 'left'")
    return 1.0 if direction == "right" else -1.0
