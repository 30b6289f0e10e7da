"""Refusals that the measurements share."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.components.errors import ParameterError, shortened


def whole_number(name: str, value: Any, least: int, most: int) -> int:
    """Return a whole number within bounds."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        raise ParameterError(f"{name}: got {shortened(value)}, expected a whole number from {least} to {most}")
    return int(value)


def sign(direction: Any) -> float:
    """+1 for what runs to the right, -1 to the left."""
    if direction not in ("right", "left"):
        raise ParameterError(f"direction: got {shortened(direction)}, expected 'right' or 'left'")
    return 1.0 if direction == "right" else -1.0
