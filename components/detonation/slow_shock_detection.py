"""Detection of slow strong shocks, which leave waves behind: they move by much less than a cell while gas runs through one.

The width of a captured shock changes while it crosses a cell. Each time mass and momentum of the zone change with it, and the
difference runs off behind as sound and entropy. Dissipation takes these waves away: the steeper the limiter, the larger they
are. Source: T. W. Roberts, J. Comput. Phys. 90 (1990) 141; measured in `tests/test_detonation_slow_shocks.py`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.float_arrays import FloatArray

# Cells from one side of a captured shock to the other.
_WIDTH = 6
_SIDES = (slice(None, -_WIDTH), slice(_WIDTH, None))
# Pressure behind over that ahead, from which on a shock counts as strong.
_STRONG = 2.0
# Speed in the tube over that through the gas ahead, below which it counts as slow.
SLOW = 0.2


class SlowShock(NamedTuple):
    """A shock that hardly moves in the tube.

    Attributes:
        cell: in the middle of it.
        speed: in the tube over that through the gas ahead of it.
    """

    cell: int
    speed: float


def find_slow_shock(density: FloatArray, velocity: FloatArray, pressure: FloatArray) -> SlowShock | None:
    """Return the strongest of the slow strong shocks, or None where there is none; its speed follows from the mass fluxes.

    Args:
        density: of the cells, shape (n,) [kg/m^3].
        velocity: shape (n,) [m/s].
        pressure: shape (n,) [Pa].
    """
    if len(pressure) <= _WIDTH:
        return None
    (r, u, p), (r2, u2, p2) = ([one[part] for one in (density, velocity, pressure)] for part in _SIDES)
    with np.errstate(all="ignore"):
        strength = np.maximum(p / p2, p2 / p)
        speed = (r2 * u2 - r * u) / (r2 - r)
        through = np.abs(speed - np.where(p > p2, u2, u))
        found = (strength > _STRONG) & (u > u2) & (np.abs(speed) < SLOW * through)
    if not found.any():
        return None
    first = int(np.where(found, strength, 0.0).argmax())
    return SlowShock(first + _WIDTH // 2, float(abs(speed[first]) / through[first]))
