"""The quantity that pictures show at the contacts in each frame of a run: the force if known, otherwise the overlap."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from granular_env.components.drawables import Points
from granular_env.components.support.float_arrays import FloatArray


def contact_quantity(
    points: Points, displacement: FloatArray | None, read: Callable[[str], FloatArray | None]
) -> tuple[FloatArray | None, str, str]:
    """Return the forces in the contacts between grains if known, otherwise the overlaps, with name and unit of this quantity.

    Args:
        points: the grains.
        displacement: shape (frames, n, 3) [m]; None if unknown.
        read: function that returns the values of the output of a given name in these frames, or None if unknown.
    """
    if len(points.radius) < 2:
        return None, "", ""
    force = read("contact_force")
    if force is not None:
        return force[:, 1:-1], "force", "N"
    if displacement is None:
        return None, "", ""
    gap = np.diff(points.reference[:, 0]) - points.radius[1:] - points.radius[:-1]
    overlap = -(gap + np.diff(displacement[..., 0], axis=1))
    # Overlaps below the rounding error are set to 0: the grains touch.
    return np.where(overlap > 1e-12 * points.radius.min(), overlap * 1e6, 0.0), "overlap", "\u00b5m"
