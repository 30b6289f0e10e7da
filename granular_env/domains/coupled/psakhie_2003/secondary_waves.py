"""Secondary waves, which an interface adds to the waves of a load: the difference to a half-space that is a grid throughout."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cases import DEPTH
from .pictures import Window
from .velocity_field import Motion

# Below this depth no Rayleigh wave is left that one would notice [m].
DEEP = 0.1
_ROWS = 200


@dataclass(frozen=True)
class Added:
    """Largest differences, in percent of the largest velocity.

    Attributes:
        back: in the grid, below `DEEP`: body waves that come back.
        back_near_surface: in the grid, above.
        on: in the automata, below `DEEP`: body waves as they went on.
        on_near_surface: in the automata, above, where the Rayleigh wave is.
    """

    back: float
    back_near_surface: float
    on: float
    on_near_surface: float


def added(coupled: Motion, alone: Motion, window: Window) -> Added:
    """Return what the interface adds at the instant of both motions."""
    columns = round(_ROWS * (window.right - window.left) / DEPTH)
    x = window.left + (np.arange(columns) + 0.5) * (window.right - window.left) / columns
    y = -np.arange(_ROWS + 1) * DEPTH / _ROWS
    places = np.meshgrid(x, y)
    gap = 100.0 * np.linalg.norm(coupled.at(*places) - alone.at(*places), axis=-1) / largest(alone)
    deep, left = y < -DEEP, x < 0.0
    return Added(*(float(gap[np.ix_(rows, side)].max()) for side in (left, ~left) for rows in (deep, ~deep)))


def largest(alone: Motion) -> float:
    """Return the largest velocity of the grid alone [m/s]."""
    return float(np.linalg.norm(alone.parts[0].velocity, axis=-1).max())
