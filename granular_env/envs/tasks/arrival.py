"""Which deadlines a wanted wave can meet: at the start it must not be in the chain yet."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...components.chain.wanted_waves import AMPLITUDE, DENSITY, PLACE, POINTS, REACH, SHAPES, SPEED, TABLES
from ...components.errors import ParameterError

FloatArray = npt.NDArray[np.float64]

# Part of a wanted wave's energy that may be in the chain when the episode begins.
_PART = 1e-3


def refuse_early(shapes: FloatArray, waves: FloatArray, duration: float, steps: int, name: str = "deadline") -> None:
    """Refuse waves that would have to be in the chain before anybody could have sent them.

    Args:
        shapes: of the waves, see `components.chain.wanted_waves`.
        waves: rows (amplitude [m/s], place, speed [grains/s]).
        duration: of a control step [s].
        steps: control steps until they are due.
        name: of the argument at fault.

    Raises:
        ParameterError: more than a thousandth of a wave's energy is in the chain at the start.
    """
    for row, wave in enumerate(waves):
        if wave[AMPLITUDE] <= 0.0 or _part_inside(shapes, row, wave, duration * steps) <= _PART:
            continue
        least = _least_steps(shapes, row, wave, duration)
        raise ParameterError(
            f"{name}: a wave of {wave[AMPLITUDE]:g} m/s that comes in at the left end takes {least} control steps of "
            f"{duration:g} s to grain {wave[PLACE]:g}, got {steps}; give deadline={least} or more, or a nearer place"
        )


def _least_steps(shapes: FloatArray, row: int, wave: FloatArray, duration: float) -> int:
    low, high = 0, 1
    while _part_inside(shapes, row, wave, duration * high) > _PART:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _part_inside(shapes, row, wave, duration * middle) <= _PART else (middle, high)
    return high


def _part_inside(shapes: FloatArray, row: int, wave: FloatArray, left: float) -> float:
    """Part of a wave's kinetic energy that is right of the first grain's left side, `left` seconds before it is due."""
    count, density = int(shapes[POINTS]), float(shapes[DENSITY])
    table = TABLES + 2 * count * min(row, int(shapes[SHAPES]) - 1)
    squares = shapes[table : table + count] ** 2
    place = (np.arange(count) - 1.0) / density - shapes[REACH] + wave[PLACE] - wave[SPEED] * left
    return float(squares[place >= -0.5].sum() / squares.sum())
