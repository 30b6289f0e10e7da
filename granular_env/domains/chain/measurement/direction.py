"""The direction of a wave, "right" or "left", as a sign."""

from __future__ import annotations

from typing import Any

from granular_env.components.errors import ParameterError, one_line


def sign(direction: Any) -> float:
    """+1 for what runs to the right, -1 to the left."""
    if direction not in ("right", "left"):
        raise ParameterError(f"got {one_line(direction)}", expected="'right' or 'left'", at="direction")
    return 1.0 if direction == "right" else -1.0
